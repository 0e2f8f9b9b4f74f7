#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

struct sqlite3;
struct sqlite3_stmt;

namespace semmap::storage::sqlite {

class Query;

struct ConnectionOptions {
  std::string path;
  bool full_synchronous = false;
  int busy_timeout_ms = 10000;
  int cache_mb = 32;
  // Refuses every change.
  bool read_only = false;
};

// One connection to a database file with the statements prepared on it. For one thread at a time.
class Connection {
 public:
  // Opens the file (creating it unless read_only) and sets what holds for a connection. What holds for the
  // file (schema, log mode) is OpenDatabase's.
  static absl::StatusOr<std::unique_ptr<Connection>> Open(const ConnectionOptions& options);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Runs one or several statements, ignoring their rows.
  absl::Status Execute(const std::string& sql);
  // Rows that the last INSERT, UPDATE or DELETE changed.
  int64_t changes() const;
  int64_t last_insert_rowid() const;
  const std::string& path() const { return path_; }
  sqlite3* handle() const { return database_; }

 private:
  friend class Query;
  struct Prepared {
    sqlite3_stmt* statement = nullptr;
    bool in_use = false;
  };

  explicit Connection(std::string path) : path_(std::move(path)) {}
  absl::Status Configure(const ConnectionOptions& options);
  // Prepared once for each distinct `sql`, which must be a constant that outlives the connection: its address
  // is its name.
  absl::StatusOr<Prepared*> Prepare(const char* sql);

  std::string path_;
  sqlite3* database_ = nullptr;
  std::unordered_map<const char*, Prepared> prepared_;
};

}  // namespace semmap::storage::sqlite
