#include "server/timer.h"

#include <utility>

#include "absl/time/clock.h"

namespace semmap::server {

Timer::Timer() : thread_([this] { Run(); }) {}

Timer::~Timer() {
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
}

void Timer::After(absl::Duration delay, std::function<void()> function) {
  MutexLock lock(&mutex_);
  schedule_.emplace(absl::Now() + delay, std::move(function));
  changed_ = true;
}

void Timer::Run() {
  while (true) {
    std::function<void()> due;
    {
      MutexLock lock(&mutex_);
      const absl::Time next = schedule_.empty() ? absl::InfiniteFuture() : schedule_.begin()->first;
      mutex_.AwaitWithDeadline(next, &Timer::FirstChanged, this);
      if (stopping_) return;
      changed_ = false;
      if (schedule_.empty() || schedule_.begin()->first > absl::Now()) continue;
      due = std::move(schedule_.begin()->second);
      schedule_.erase(schedule_.begin());
    }
    due();
  }
}

}  // namespace semmap::server
