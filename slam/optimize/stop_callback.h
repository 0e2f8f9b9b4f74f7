#pragma once

#include <atomic>

#include <ceres/iteration_callback.h>

namespace semmap {

// Ends a Ceres solve, with the best solution so far, once a flag that another thread may set is true. A null
// flag never ends it.
class StopCallback final : public ceres::IterationCallback {
 public:
  explicit StopCallback(const std::atomic<bool>* stop) : stop_(stop) {}

  bool Requested() const { return stop_ != nullptr && stop_->load(std::memory_order_relaxed); }
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return Requested() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::atomic<bool>* stop_;
};

}  // namespace semmap
