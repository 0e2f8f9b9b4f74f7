#include "storage/sqlite/migrations.h"

#include <spdlog/spdlog.h>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/transaction.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kSelectApplicationId[] = "PRAGMA application_id";
constexpr char kSelectVersion[] = "PRAGMA user_version";
constexpr char kCountSchema[] = "SELECT count(*) FROM sqlite_schema";

// The version of a database of ours; 0 for a file without content.
absl::StatusOr<int64_t> ReadVersion(Connection& connection, std::span<const Migration> migrations) {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t application, QueryInteger(connection, kSelectApplicationId));
  SEMMAP_ASSIGN_OR_RETURN(const int64_t version, QueryInteger(connection, kSelectVersion));
  SEMMAP_ASSIGN_OR_RETURN(const int64_t tables, QueryInteger(connection, kCountSchema));
  if (application == 0 && version == 0 && tables == 0) return 0;
  if (application != kApplicationId) {
    return absl::FailedPreconditionError(
        absl::StrCat(connection.path(), " is a database of another program"));
  }
  const auto known = static_cast<int64_t>(migrations.size());
  if (version < 1 || version > known) {
    return absl::FailedPreconditionError(
        absl::StrCat(connection.path(), " has schema version ", version, ", this program knows 1 to ", known,
                     version > known ? ": it was written by a newer semmap" : ""));
  }
  return version;
}

absl::Status RunMissing(Connection& connection, std::span<const Migration> migrations) {
  SEMMAP_ASSIGN_OR_RETURN(Transaction transaction,
                          Transaction::Begin(connection, Transaction::Kind::kExclusive));
  // Somebody else may have done it while we waited for the lock.
  SEMMAP_ASSIGN_OR_RETURN(const int64_t version, ReadVersion(connection, migrations));
  for (const Migration& migration : migrations.subspan(static_cast<size_t>(version))) {
    spdlog::info("storage: {}: running migration {}", connection.path(), migration.name);
    SEMMAP_RETURN_IF_ERROR(connection.Execute(migration.sql));
  }
  SEMMAP_RETURN_IF_ERROR(connection.Execute(
      absl::StrCat("PRAGMA application_id=", kApplicationId, "; PRAGMA user_version=", migrations.size())));
  return transaction.Commit();
}

}  // namespace

absl::Status MigrateDatabase(Connection& connection, std::span<const Migration> migrations) {
  // Looked at first, so that nothing is written to a file that is not ours.
  SEMMAP_ASSIGN_OR_RETURN(const int64_t version, ReadVersion(connection, migrations));
  SEMMAP_RETURN_IF_ERROR(connection.Execute("PRAGMA journal_mode=WAL"));
  if (version == static_cast<int64_t>(migrations.size())) return absl::OkStatus();
  return RunMissing(connection, migrations);
}

}  // namespace semmap::storage::sqlite
