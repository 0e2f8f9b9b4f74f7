#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/client_callback.h>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "semmap/v1/session_service.grpc.pb.h"
#include "slam/common/mutex.h"

namespace semmap::client {

// One gRPC stream of a drive; a drive that resumes goes through several, one after the other. Callbacks come
// one at a time from gRPC's threads; `on_end` is the last, and always comes. Keep the stream until then, and
// no longer than the program: what hangs on it must not be released while gRPC shuts down.
class DriveStream : public grpc::ClientBidiReactor<v1::StreamFramesRequest, v1::StreamFramesResponse> {
 public:
  using OnMessage = std::function<void(const v1::StreamFramesResponse&)>;
  using OnEnd = std::function<void(const absl::Status&)>;

  static std::unique_ptr<DriveStream> Open(v1::SessionService::Stub* stub, OnMessage on_message,
                                           OnEnd on_end);

  // Writes one message and waits until gRPC has taken it (flow control). False: the stream has ended or will,
  // or nothing moved within `timeout` and the stream was cancelled. One call at a time.
  bool Write(v1::StreamFramesRequest request, std::chrono::milliseconds timeout);
  // Breaks the stream; harmless when it has ended.
  void Cancel();

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

 private:
  DriveStream(OnMessage on_message, OnEnd on_end);

  bool NotWriting() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !writing_; }
  // gRPC calls OnDone only after the hold is gone, and takes no write after OnDone: the hold goes when the
  // stream is closed and no write is under way.
  void Close(bool write_is_over);

  const OnMessage on_message_;
  const OnEnd on_end_;
  grpc::ClientContext context_;
  v1::StreamFramesResponse response_;  // of the read under way
  v1::StreamFramesRequest request_;    // of the write under way

  Mutex mutex_;  // guards all below
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  bool held_ ABSL_GUARDED_BY(mutex_) = true;
};

}  // namespace semmap::client
