#pragma once

#include <chrono>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/client_callback.h>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "client/grpc_status.h"
#include "slam/common/mutex.h"

namespace semmap::client {

// Sends a stream of requests message by message, with a limit for each message instead of one for the whole
// call. Start the call, then call Begin; Finish before the writer goes. The counterpart of MessageReader.
template <typename Request, typename Response>
class MessageWriter : public grpc::ClientWriteReactor<Request> {
 public:
  void Begin() {
    this->AddHold();
    this->StartCall();
  }

  grpc::ClientContext* context() { return &context_; }
  Response* response() { return &response_; }

  // False when the server takes no more, or did not in time: see Finish.
  bool Write(const Request& request, std::chrono::milliseconds timeout) {
    {
      MutexLock lock(&mutex_);
      state_ = State::kWriting;
    }
    this->StartWrite(&request);
    MutexLock lock(&mutex_);
    if (!mutex_.AwaitWithTimeout(absl::FromChrono(timeout), &MessageWriter::IsWritten, this)) {
      timed_out_ = true;
      context_.TryCancel();
      mutex_.Await(&MessageWriter::IsWritten, this);
    }
    return state_ == State::kReady;
  }

  // Ends the stream and tells how the call went. Call it once.
  absl::Status Finish(bool cancel, std::chrono::milliseconds timeout) {
    if (cancel) context_.TryCancel();
    this->StartWritesDone();
    this->RemoveHold();
    MutexLock lock(&mutex_);
    if (!mutex_.AwaitWithTimeout(absl::FromChrono(timeout), &MessageWriter::IsDone, this)) {
      timed_out_ = true;
      context_.TryCancel();
      mutex_.Await(&MessageWriter::IsDone, this);
    }
    if (timed_out_) return absl::DeadlineExceededError("the server took nothing in time");
    return FromGrpc(status_);
  }

  void OnWriteDone(bool ok) override {
    MutexLock lock(&mutex_);
    state_ = ok ? State::kReady : State::kClosed;
  }

  void OnDone(const grpc::Status& status) override {
    MutexLock lock(&mutex_);
    status_ = status;
    done_ = true;
  }

 private:
  enum class State { kReady, kWriting, kClosed };

  bool IsWritten() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return state_ != State::kWriting; }
  bool IsDone() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return done_; }

  grpc::ClientContext context_;
  Response response_;
  Mutex mutex_;  // guards all below
  State state_ ABSL_GUARDED_BY(mutex_) = State::kReady;
  bool timed_out_ ABSL_GUARDED_BY(mutex_) = false;
  bool done_ ABSL_GUARDED_BY(mutex_) = false;
  grpc::Status status_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::client
