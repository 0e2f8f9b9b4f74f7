#pragma once

#include <deque>
#include <functional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "slam/common/mutex.h"

namespace semmap::server {

// The one thread that writes the changes of maps to the store. Jobs run in the order in which they came; the
// queue is bounded, and whoever brings a job to a full queue waits: mappers slow down to the pace of the disk
// instead of filling the memory. Thread-safe.
class MapWriter {
 public:
  explicit MapWriter(size_t capacity);
  // Runs what is queued, then stops.
  ~MapWriter();
  MapWriter(const MapWriter&) = delete;
  MapWriter& operator=(const MapWriter&) = delete;

  // Must not be called from a job.
  void Post(std::function<void()> job);
  size_t waiting() const;

 private:
  void Run();
  bool HasRoom() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return jobs_.size() < capacity_; }
  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_ || !jobs_.empty(); }

  const size_t capacity_;
  mutable Mutex mutex_;  // guards the queue
  std::deque<std::function<void()>> jobs_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace semmap::server
