#include "storage/sqlite/transaction.h"

#include <spdlog/spdlog.h>
#include <sqlite3.h>

#include <utility>

#include "slam/common/status_macros.h"
#include "storage/sqlite/query.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kBeginRead[] = "BEGIN";
constexpr char kBeginWrite[] = "BEGIN IMMEDIATE";
constexpr char kBeginExclusive[] = "BEGIN EXCLUSIVE";
constexpr char kCommit[] = "COMMIT";
constexpr char kRollback[] = "ROLLBACK";

const char* BeginStatement(Transaction::Kind kind) {
  switch (kind) {
    case Transaction::Kind::kRead:
      return kBeginRead;
    case Transaction::Kind::kWrite:
      return kBeginWrite;
    case Transaction::Kind::kExclusive:
      break;
  }
  return kBeginExclusive;
}

}  // namespace

absl::StatusOr<Transaction> Transaction::Begin(Connection& connection, Kind kind) {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, BeginStatement(kind)));
  return Transaction(connection);
}

Transaction::Transaction(Transaction&& other) noexcept
    : connection_(std::exchange(other.connection_, nullptr)) {}

Transaction::~Transaction() {
  // SQLite itself rolls back after some failures (a full disk): then there is nothing left to do.
  if (connection_ == nullptr || sqlite3_get_autocommit(connection_->handle()) != 0) return;
  const absl::Status status = RunQuery(*connection_, kRollback);
  if (!status.ok()) spdlog::error("storage: rollback failed: {}", std::string(status.message()));
}

absl::Status Transaction::Commit() {
  SEMMAP_RETURN_IF_ERROR(RunQuery(*connection_, kCommit));
  connection_ = nullptr;
  return absl::OkStatus();
}

}  // namespace semmap::storage::sqlite
