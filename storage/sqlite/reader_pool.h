#pragma once

#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "slam/common/mutex.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/transaction.h"

namespace semmap::storage::sqlite {

// Read-only connections, opened as they are needed up to a limit and used again. Thread-safe; must outlive
// what it lends.
class ReaderPool {
 public:
  // A connection inside a read transaction, given back at the end of its life.
  class Lease {
   public:
    ~Lease();
    Lease(Lease&& other) noexcept = default;
    Lease& operator=(Lease&&) = delete;
    Connection& connection() { return *connection_; }

   private:
    friend class ReaderPool;
    Lease(ReaderPool* pool, std::unique_ptr<Connection> connection, Transaction transaction);

    ReaderPool* pool_;
    std::unique_ptr<Connection> connection_;
    std::unique_ptr<Transaction> transaction_;
  };

  // `options` of the connections; read_only is set here.
  ReaderPool(ConnectionOptions options, int max_connections);

  // One consistent state of the database for as long as the lease lives. UNAVAILABLE when all connections
  // stay lent for the busy timeout.
  absl::StatusOr<Lease> Read();

 private:
  bool CanLend() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(idle_mutex_) {
    return !idle_.empty() || lent_ < max_connections_;
  }
  absl::StatusOr<std::unique_ptr<Connection>> Take();
  void GiveBack(std::unique_ptr<Connection> connection);

  const ConnectionOptions options_;
  const int max_connections_;
  Mutex idle_mutex_;
  std::vector<std::unique_ptr<Connection>> idle_ ABSL_GUARDED_BY(idle_mutex_);
  int lent_ ABSL_GUARDED_BY(idle_mutex_) = 0;
};

}  // namespace semmap::storage::sqlite
