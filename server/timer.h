#pragma once

#include <functional>
#include <map>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "slam/common/mutex.h"

namespace semmap::server {

// Calls functions later, on one thread of its own; they must be short. There is no cancelling: a function
// looks for itself whether it is still wanted. The destructor drops what has not come due. Thread-safe.
class Timer {
 public:
  Timer();
  ~Timer();
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  void After(absl::Duration delay, std::function<void()> function);

 private:
  void Run();
  bool FirstChanged() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return changed_ || stopping_; }

  Mutex mutex_;  // guards the schedule
  std::multimap<absl::Time, std::function<void()>> schedule_ ABSL_GUARDED_BY(mutex_);
  bool changed_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace semmap::server
