#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>

#include "absl/base/thread_annotations.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace semmap {

// A mutex whose holders can wait for conditions, like absl::Mutex: nobody signals, every release lets the
// waiting threads look again. It stands on std::mutex because Debian's Abseil is built without the thread
// sanitizer, which therefore sees no synchronization in absl::Mutex and reports races everywhere.
//
// A condition is called while the mutex is held, in the thread that waits, and must depend only on what the
// mutex guards (and what the caller holds still). Not reentrant. It may be destroyed as soon as no thread
// waits for or holds it, even while the thread that released it last is still on its way out of Unlock.
//
// Header only: the client library includes it without linking anything of slam.
class ABSL_LOCKABLE Mutex {
 public:
  Mutex() = default;
  Mutex(const Mutex&) = delete;
  Mutex& operator=(const Mutex&) = delete;

  void Lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() ABSL_NO_THREAD_SAFETY_ANALYSIS { mutex_.lock(); }

  void Unlock() ABSL_UNLOCK_FUNCTION() ABSL_NO_THREAD_SAFETY_ANALYSIS {
    WakeWaiting();
    mutex_.unlock();
  }

  // Tells the thread-safety analysis, in a lambda say, that the caller holds this mutex.
  void AssertHeld() const ABSL_ASSERT_EXCLUSIVE_LOCK() {}

  // Releases the mutex until std::invoke(condition, arguments...) is true.
  template <typename Condition, typename... Arguments>
  void Await(const Condition& condition, const Arguments&... arguments)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(this) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    if (std::invoke(condition, arguments...)) return;
    Waiting waiting(this);
    changed_.wait(waiting.lock, [&] { return std::invoke(condition, arguments...); });
  }

  // The same for at most `timeout`, which may be infinite; what the condition was in the end.
  template <typename Condition, typename... Arguments>
  bool AwaitWithTimeout(absl::Duration timeout, const Condition& condition, const Arguments&... arguments)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(this) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    if (std::invoke(condition, arguments...)) return true;
    Waiting waiting(this);
    const auto deadline =
        std::chrono::steady_clock::now() + absl::ToChronoNanoseconds(std::min(timeout, kLongestWait));
    return changed_.wait_until(waiting.lock, deadline, [&] { return std::invoke(condition, arguments...); });
  }

  template <typename Condition, typename... Arguments>
  bool AwaitWithDeadline(absl::Time deadline, const Condition& condition, const Arguments&... arguments)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(this) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    return AwaitWithTimeout(deadline - absl::Now(), condition, arguments...);
  }

 private:
  // Longer ones would overflow the clock.
  static constexpr absl::Duration kLongestWait = absl::Hours(24 * 365);

  // Lends the mutex, which the caller holds, to a std::unique_lock for as long as the caller waits.
  struct Waiting {
    explicit Waiting(Mutex* waited_for) : mutex(waited_for), lock(waited_for->mutex_, std::adopt_lock) {
      // Waiting releases the mutex, too: what the caller changed before may be what another waits for.
      mutex->WakeWaiting();
      ++mutex->waiting_;
    }
    ~Waiting() {
      --mutex->waiting_;
      lock.release();  // the caller goes on holding it
    }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;

    Mutex* const mutex;
    std::unique_lock<std::mutex> lock;
  };

  // Before the release, not after it: afterwards this object may be gone.
  void WakeWaiting() {
    if (waiting_ > 0) changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  int waiting_ = 0;  // threads inside Await; guarded by mutex_
};

// Holds a mutex for as long as it lives.
class ABSL_SCOPED_LOCKABLE MutexLock {
 public:
  explicit MutexLock(Mutex* mutex) ABSL_EXCLUSIVE_LOCK_FUNCTION(mutex) : mutex_(mutex) { mutex_->Lock(); }
  ~MutexLock() ABSL_UNLOCK_FUNCTION() { mutex_->Unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Mutex* const mutex_;
};

}  // namespace semmap
