#pragma once

#include <atomic>
#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "server/error_reasons.h"
#include "server/service_context.h"
#include "slam/pipeline/executor.h"

namespace semmap::server {

// Where handlers run: on the query threads, never on gRPC's, and only so many at a time. Thread-safe.
class CallRunner {
 public:
  CallRunner(const ServiceContext& context, Executor* threads) : context_(context), threads_(threads) {}

  const ServiceContext& context() const { return context_; }

  // Takes a call in, or refuses it with TOO_MANY_REQUESTS. Each call taken in is to be released once.
  absl::Status Admit() {
    if (++calls_ <= context_.config.max_queries) return absl::OkStatus();
    --calls_;
    return Error(v1::ERROR_REASON_TOO_MANY_REQUESTS,
                 "the server answers as many calls as it is configured for");
  }
  void Release() { --calls_; }

  void Run(std::function<void()> task) { threads_->Schedule(std::move(task)); }

 private:
  const ServiceContext& context_;
  Executor* const threads_;
  std::atomic<int> calls_{0};
};

}  // namespace semmap::server
