#pragma once

#include <chrono>
#include <memory>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/client_callback.h>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client/grpc_status.h"

namespace semmap::client {

// Reads a streamed answer message by message, with a limit for each message instead of one for the whole
// call. Make it with std::make_shared, start the call, then call Begin.
template <typename Response>
class MessageReader : public grpc::ClientReadReactor<Response> {
 public:
  // gRPC uses the reader until OnDone: it keeps itself alive until then.
  void Begin(std::shared_ptr<MessageReader> self) {
    self_ = std::move(self);
    this->AddHold();
    this->StartCall();
  }

  grpc::ClientContext* context() { return &context_; }

  // The next message; nullptr at the end of the stream or when nothing came in time: see Finish.
  const Response* Next(std::chrono::milliseconds timeout) {
    {
      absl::MutexLock lock(&mutex_);
      state_ = State::kReading;
    }
    this->StartRead(&response_);
    absl::MutexLock lock(&mutex_);
    const absl::Condition arrived(this, &MessageReader::IsRead);
    if (!mutex_.AwaitWithTimeout(arrived, absl::FromChrono(timeout))) {
      timed_out_ = true;
      context_.TryCancel();
      mutex_.Await(arrived);
    }
    return state_ == State::kMessage ? &response_ : nullptr;
  }

  // Ends the call, whether all was read or not, and tells how it went. Call it once.
  absl::Status Finish(bool cancel) {
    if (cancel) context_.TryCancel();
    this->RemoveHold();
    absl::MutexLock lock(&mutex_);
    mutex_.Await(absl::Condition(this, &MessageReader::IsDone));
    if (timed_out_) return absl::DeadlineExceededError("the server sent nothing in time");
    return FromGrpc(status_);
  }

  void OnReadDone(bool ok) override {
    absl::MutexLock lock(&mutex_);
    state_ = ok ? State::kMessage : State::kEnd;
  }

  void OnDone(const grpc::Status& status) override {
    const std::shared_ptr<MessageReader> self = std::move(self_);
    absl::MutexLock lock(&mutex_);
    status_ = status;
    done_ = true;
  }

 private:
  enum class State { kReading, kMessage, kEnd };

  bool IsRead() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return state_ != State::kReading; }
  bool IsDone() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return done_; }

  std::shared_ptr<MessageReader> self_;
  grpc::ClientContext context_;
  Response response_;
  absl::Mutex mutex_;  // guards all below
  State state_ ABSL_GUARDED_BY(mutex_) = State::kEnd;
  bool timed_out_ ABSL_GUARDED_BY(mutex_) = false;
  bool done_ ABSL_GUARDED_BY(mutex_) = false;
  grpc::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::client
