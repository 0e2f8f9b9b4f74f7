#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "google/protobuf/message.h"
#include "semmap/v1/operation.pb.h"
#include "slam/common/mutex.h"
#include "slam/common/time.h"
#include "slam/pipeline/executor.h"

namespace semmap::server {

// How the work of an operation tells how far it is, and learns that it should stop. Thread-safe.
class OperationProgress {
 public:
  void Report(double share) { share_ = share; }
  // What is being done from now on, for people: a string literal.
  void Enter(const char* stage) { stage_ = stage; }
  // For the metadata of the operation.
  void Tell(const v1::OptimizeReport& report);
  void Tell(const v1::PruneReport& report);
  bool CancelRequested() const { return cancel_requested_; }
  // The same for solvers that look at a flag.
  const std::atomic<bool>* cancel_flag() const { return &cancel_requested_; }

 private:
  friend class Operations;
  std::atomic<const char*> stage_ = "";
  mutable Mutex mutex_;  // guards the report
  v1::OperationMetadata report_ ABSL_GUARDED_BY(mutex_);
  std::atomic<double> share_ = 0;
  std::atomic<bool> cancel_requested_ = false;
};

// Long-running operations: starts them, one after the other on the threads it is given, and remembers the
// last thousand that are done. They live in memory; after a restart of the server their names are unknown.
// Thread-safe.
class Operations {
 public:
  // The response message of the operation, or why it failed.
  using Result = absl::StatusOr<std::unique_ptr<google::protobuf::Message>>;
  // Is destroyed before the operation is told to be done, whether it was called or cancelled before.
  using Work = std::function<Result(OperationProgress&)>;
  using Done = std::function<void(const v1::Operation&)>;

  // `threads` runs the work and outlives this.
  Operations(Executor* threads, std::function<TimestampNs()> wall_clock);
  // Stops, and returns when nothing runs any more.
  ~Operations();
  Operations(const Operations&) = delete;
  Operations& operator=(const Operations&) = delete;

  // TOO_MANY_REQUESTS, SHUTTING_DOWN.
  absl::StatusOr<v1::Operation> Start(v1::OperationKind kind, const std::vector<std::string>& map_ids,
                                      Work work);
  // Starts nothing more, asks what runs to stop, and answers those who wait, so that their calls end.
  void Stop();

  // By id. OPERATION_NOT_FOUND.
  absl::StatusOr<v1::Operation> Get(const std::string& id) const;
  // Newest first; of one map, when `map_id` is not empty.
  std::vector<v1::Operation> List(const std::string& map_id) const;
  // Calls `done` once, from any thread: when the operation is done, or all are stopped.
  absl::Status WhenDone(const std::string& id, Done done);
  // OPERATION_NOT_FOUND; one that is done stays as it is.
  absl::Status Cancel(const std::string& id);
  // OPERATION_NOT_FOUND; FIELD_INVALID while it runs.
  absl::Status Forget(const std::string& id);

 private:
  struct Entry {
    v1::Operation operation;
    OperationProgress progress;
    std::vector<Done> waiting;
  };

  void Run(const std::shared_ptr<Entry>& entry, Work work);
  void Finish(const std::shared_ptr<Entry>& entry, const Result& result);
  void ForgetOldest() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<std::shared_ptr<Entry>> Find(const std::string& id) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static v1::Operation Describe(const Entry& entry);
  bool NothingRuns() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return running_ == 0; }

  Executor* const threads_;
  const std::function<TimestampNs()> wall_clock_;

  mutable Mutex mutex_;  // guards all below and the entries' operations and waiting
  std::map<uint64_t, std::shared_ptr<Entry>> entries_ ABSL_GUARDED_BY(mutex_);  // by number, which is the id
  uint64_t last_number_ ABSL_GUARDED_BY(mutex_) = 0;
  int running_ ABSL_GUARDED_BY(mutex_) = 0;  // or waiting for a thread
  bool closing_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace semmap::server
