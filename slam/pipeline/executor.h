#pragma once

#include <functional>
#include <memory>

namespace semmap {

// Runs tasks on threads it owns; many sessions share one. Thread-safe.
class Executor {
 public:
  virtual ~Executor() = default;
  virtual void Schedule(std::function<void()> task) = 0;
};

// A fixed pool of threads with one queue. The destructor finishes what is queued.
std::unique_ptr<Executor> MakeThreadPool(int threads);

}  // namespace semmap
