#include "storage/sqlite/reader_pool.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap::storage::sqlite {
namespace {

ConnectionOptions ReadOnly(ConnectionOptions options) {
  options.read_only = true;
  return options;
}

}  // namespace

ReaderPool::Lease::Lease(ReaderPool* pool, std::unique_ptr<Connection> connection, Transaction transaction)
    : pool_(pool),
      connection_(std::move(connection)),
      transaction_(std::make_unique<Transaction>(std::move(transaction))) {}

ReaderPool::Lease::~Lease() {
  if (connection_ == nullptr) return;
  transaction_.reset();
  pool_->GiveBack(std::move(connection_));
}

ReaderPool::ReaderPool(ConnectionOptions options, int max_connections)
    : options_(ReadOnly(std::move(options))), max_connections_(max_connections) {}

absl::StatusOr<ReaderPool::Lease> ReaderPool::Read() {
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<Connection> connection, Take());
  absl::StatusOr<Transaction> transaction = Transaction::Begin(*connection, Transaction::Kind::kRead);
  if (!transaction.ok()) {
    GiveBack(std::move(connection));
    return transaction.status();
  }
  return Lease(this, std::move(connection), *std::move(transaction));
}

absl::StatusOr<std::unique_ptr<Connection>> ReaderPool::Take() {
  {
    MutexLock lock(&idle_mutex_);
    const absl::Duration timeout = absl::Milliseconds(options_.busy_timeout_ms);
    if (!idle_mutex_.AwaitWithTimeout(timeout, &ReaderPool::CanLend, this)) {
      return absl::UnavailableError(
          absl::StrCat("all ", max_connections_, " readers of the database are busy"));
    }
    ++lent_;
    if (!idle_.empty()) {
      std::unique_ptr<Connection> connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
  }
  absl::StatusOr<std::unique_ptr<Connection>> opened = Connection::Open(options_);
  if (!opened.ok()) GiveBack(nullptr);
  return opened;
}

void ReaderPool::GiveBack(std::unique_ptr<Connection> connection) {
  MutexLock lock(&idle_mutex_);
  --lent_;
  if (connection != nullptr) idle_.push_back(std::move(connection));
}

}  // namespace semmap::storage::sqlite
