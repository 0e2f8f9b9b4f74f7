#pragma once

#include <memory>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "slam/common/mutex.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// Moves what was committed from the write-ahead log into the database file (SQLite calls it a checkpoint), on
// a thread and a connection of its own: it waits for the disk, which a commit otherwise would every so often.
class Checkpointer {
 public:
  static absl::StatusOr<std::unique_ptr<Checkpointer>> Start(const ConnectionOptions& options);
  // Waits for a checkpoint that is under way.
  ~Checkpointer();
  Checkpointer(const Checkpointer&) = delete;
  Checkpointer& operator=(const Checkpointer&) = delete;

  // From now on commits of `writer` wake the thread when the log has grown enough. Should the log outgrow it
  // all the same, because commits follow each other without a gap, a commit does the work itself. The writer
  // must be closed before this object goes.
  void Watch(Connection& writer);

 private:
  explicit Checkpointer(std::unique_ptr<Connection> connection);
  static int OnCommit(void* self, struct sqlite3* database, const char* schema, int pages_in_log);
  void Run();

  const std::unique_ptr<Connection> connection_;  // used by thread_ only
  Mutex wake_mutex_;
  bool wanted_ ABSL_GUARDED_BY(wake_mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(wake_mutex_) = false;
  std::thread thread_;
};

}  // namespace semmap::storage::sqlite
