#include "storage/sqlite/checkpointer.h"

#include <spdlog/spdlog.h>
#include <sqlite3.h>

#include <utility>

#include "slam/common/status_macros.h"

namespace semmap::storage::sqlite {
namespace {

// Pages of 4 kB. Neighbouring keyframes change the same pages: a checkpoint after several of them writes each
// once.
constexpr int kPagesToStart = 2048;
constexpr int kPagesAtMost = 16384;

// Moves as much as no reader holds back.
int Checkpoint(sqlite3* database) {
  return sqlite3_wal_checkpoint_v2(database, nullptr, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Checkpointer>> Checkpointer::Start(const ConnectionOptions& options) {
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<Connection> connection, Connection::Open(options));
  return std::unique_ptr<Checkpointer>(new Checkpointer(std::move(connection)));
}

Checkpointer::Checkpointer(std::unique_ptr<Connection> connection)
    : connection_(std::move(connection)), thread_([this] { Run(); }) {}

Checkpointer::~Checkpointer() {
  {
    MutexLock lock(&wake_mutex_);
    stopping_ = true;
  }
  thread_.join();
}

void Checkpointer::Watch(Connection& writer) {
  sqlite3_wal_hook(writer.handle(), &Checkpointer::OnCommit, this);
}

int Checkpointer::OnCommit(void* self, sqlite3* database, const char* /*schema*/, int pages_in_log) {
  if (pages_in_log < kPagesToStart) return SQLITE_OK;
  // Whether this works out or not, the commit stands.
  if (pages_in_log >= kPagesAtMost) Checkpoint(database);
  auto* checkpointer = static_cast<Checkpointer*>(self);
  MutexLock lock(&checkpointer->wake_mutex_);
  checkpointer->wanted_ = true;
  return SQLITE_OK;
}

void Checkpointer::Run() {
  const auto has_work = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(wake_mutex_) { return wanted_ || stopping_; };
  while (true) {
    {
      MutexLock lock(&wake_mutex_);
      wake_mutex_.Await(has_work);
      if (stopping_) return;
      wanted_ = false;
    }
    const int code = Checkpoint(connection_->handle());
    // Busy: somebody else is at it. The next commit asks again.
    if (code != SQLITE_OK && (code & 0xFF) != SQLITE_BUSY) {
      spdlog::warn("storage: checkpoint of {}: {}", connection_->path(), sqlite3_errstr(code));
    }
  }
}

}  // namespace semmap::storage::sqlite
