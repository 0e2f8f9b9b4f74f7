#include "storage/sqlite/connection.h"

#include <sqlite3.h>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/sqlite_status.h"

namespace semmap::storage::sqlite {
namespace {

// After the log was emptied into the database, its file is cut back to this.
constexpr int64_t kLogSizeLimit = 64 << 20;

int OpenFlags(bool read_only) {
  // No mutex: a connection is used by one thread at a time. Read-only connections are opened for writing as
  // well, because readers of a log keep their marks in its shared index; query_only holds them back.
  const int common = SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE | SQLITE_OPEN_READWRITE;
  return read_only ? common : common | SQLITE_OPEN_CREATE;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Connection>> Connection::Open(const ConnectionOptions& options) {
  std::unique_ptr<Connection> connection(new Connection(options.path));
  const int code =
      sqlite3_open_v2(options.path.c_str(), &connection->database_, OpenFlags(options.read_only), nullptr);
  const std::string doing = absl::StrCat("opening ", options.path);
  SEMMAP_RETURN_IF_ERROR(SqliteStatus(connection->database_, code, doing));
  SEMMAP_RETURN_IF_ERROR(connection->Configure(options));
  return connection;
}

Connection::~Connection() {
  for (const auto& [sql, prepared] : prepared_) sqlite3_finalize(prepared.statement);
  sqlite3_close(database_);
}

absl::Status Connection::Configure(const ConnectionOptions& options) {
  sqlite3_busy_timeout(database_, options.busy_timeout_ms);
  // A database file may come from anywhere: nothing in its schema may do more than store.
  sqlite3_db_config(database_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(database_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  return Execute(absl::StrCat("PRAGMA foreign_keys=ON; PRAGMA temp_store=MEMORY; PRAGMA cell_size_check=ON;",
                              "PRAGMA synchronous=", options.full_synchronous ? "FULL" : "NORMAL", ";",
                              "PRAGMA cache_size=-", options.cache_mb * 1024, ";",
                              "PRAGMA journal_size_limit=", kLogSizeLimit, ";",
                              "PRAGMA query_only=", options.read_only ? "ON" : "OFF", ";"));
}

absl::Status Connection::Execute(const std::string& sql) {
  const int code = sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr);
  return SqliteStatus(database_, code, path_);
}

int64_t Connection::changes() const { return sqlite3_changes64(database_); }

int64_t Connection::last_insert_rowid() const { return sqlite3_last_insert_rowid(database_); }

absl::StatusOr<Connection::Prepared*> Connection::Prepare(const char* sql) {
  Prepared& prepared = prepared_[sql];
  if (prepared.statement != nullptr) return &prepared;
  const int code =
      sqlite3_prepare_v3(database_, sql, -1, SQLITE_PREPARE_PERSISTENT, &prepared.statement, nullptr);
  SEMMAP_RETURN_IF_ERROR(SqliteStatus(database_, code, absl::StrCat(path_, ": preparing \"", sql, "\"")));
  return &prepared;
}

}  // namespace semmap::storage::sqlite
