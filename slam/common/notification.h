#pragma once

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "slam/common/mutex.h"

namespace semmap {

// An event that happens once and that threads can wait for; see Mutex for why this is not absl::Notification.
// Thread-safe.
class Notification {
 public:
  void Notify() {
    MutexLock lock(&mutex_);
    notified_ = true;
  }
  bool HasBeenNotified() const {
    MutexLock lock(&mutex_);
    return notified_;
  }
  void WaitForNotification() const {
    MutexLock lock(&mutex_);
    mutex_.Await(&Notification::IsNotified, this);
  }
  // Whether it happened within `timeout`.
  bool WaitForNotificationWithTimeout(absl::Duration timeout) const {
    MutexLock lock(&mutex_);
    return mutex_.AwaitWithTimeout(timeout, &Notification::IsNotified, this);
  }

 private:
  bool IsNotified() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return notified_; }

  mutable Mutex mutex_;
  bool notified_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace semmap
