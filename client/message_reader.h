#pragma once

#include <chrono>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/client_callback.h>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "client/grpc_status.h"
#include "slam/common/mutex.h"

namespace semmap::client {

// Reads a streamed answer message by message, with a limit for each message instead of one for the whole
// call. Start the call, then call Begin; Finish before the reader goes. Its owner, not gRPC's thread, takes
// it apart: what hangs on the call must not be released while the program already ends.
template <typename Response>
class MessageReader : public grpc::ClientReadReactor<Response> {
 public:
  void Begin() {
    this->AddHold();
    this->StartCall();
  }

  grpc::ClientContext* context() { return &context_; }

  // The next message; nullptr at the end of the stream or when nothing came in time: see Finish.
  const Response* Next(std::chrono::milliseconds timeout) {
    {
      MutexLock lock(&mutex_);
      state_ = State::kReading;
    }
    this->StartRead(&response_);
    MutexLock lock(&mutex_);
    if (!mutex_.AwaitWithTimeout(absl::FromChrono(timeout), &MessageReader::IsRead, this)) {
      timed_out_ = true;
      context_.TryCancel();
      mutex_.Await(&MessageReader::IsRead, this);
    }
    return state_ == State::kMessage ? &response_ : nullptr;
  }

  // Ends the call, whether all was read or not, and tells how it went. Call it once.
  absl::Status Finish(bool cancel) {
    if (cancel) context_.TryCancel();
    this->RemoveHold();
    MutexLock lock(&mutex_);
    mutex_.Await(&MessageReader::IsDone, this);
    if (timed_out_) return absl::DeadlineExceededError("the server sent nothing in time");
    return FromGrpc(status_);
  }

  void OnReadDone(bool ok) override {
    MutexLock lock(&mutex_);
    state_ = ok ? State::kMessage : State::kEnd;
  }

  void OnDone(const grpc::Status& status) override {
    MutexLock lock(&mutex_);
    status_ = status;
    done_ = true;
  }

 private:
  enum class State { kReading, kMessage, kEnd };

  bool IsRead() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return state_ != State::kReading; }
  bool IsDone() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return done_; }

  grpc::ClientContext context_;
  Response response_;
  Mutex mutex_;  // guards all below
  State state_ ABSL_GUARDED_BY(mutex_) = State::kEnd;
  bool timed_out_ ABSL_GUARDED_BY(mutex_) = false;
  bool done_ ABSL_GUARDED_BY(mutex_) = false;
  grpc::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::client
