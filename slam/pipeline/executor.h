#pragma once

#include <functional>
#include <memory>

namespace semmap {

// Runs tasks on threads it owns; many sessions share one. Thread-safe.
class Executor {
 public:
  virtual ~Executor() = default;
  virtual void Schedule(std::function<void()> task) = 0;
  // For what takes seconds and may wait as long: it must not hold up what was given to Schedule.
  virtual void ScheduleLong(std::function<void()> task) = 0;
};

// A fixed pool of threads with one queue, and one more thread with a queue of its own for long tasks. The
// destructor finishes what is queued.
std::unique_ptr<Executor> MakeThreadPool(int threads);

}  // namespace semmap
