#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// A transaction that takes back everything unless Commit was called and succeeded. Queries of the connection
// that began within it must end before it does.
class Transaction {
 public:
  enum class Kind {
    kRead,       // one snapshot for all reads; never waits
    kWrite,      // takes the write lock at once, waiting for the busy timeout
    kExclusive,  // as kWrite; outside WAL mode keeps readers out, too
  };

  static absl::StatusOr<Transaction> Begin(Connection& connection, Kind kind);
  ~Transaction();
  Transaction(Transaction&& other) noexcept;
  Transaction& operator=(Transaction&&) = delete;

  absl::Status Commit();

 private:
  explicit Transaction(Connection& connection) : connection_(&connection) {}

  Connection* connection_;  // null: over
};

}  // namespace semmap::storage::sqlite
