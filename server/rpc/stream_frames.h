#pragma once

#include <memory>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/server_callback.h>

#include "absl/base/thread_annotations.h"
#include "semmap/v1/session.pb.h"
#include "server/rpc/call_runner.h"
#include "server/vehicle_session.h"
#include "slam/common/mutex.h"

namespace semmap::server {

// One stream of StreamFrames: reads messages for its session and writes what the session has to say. All that
// takes time happens elsewhere; the stream itself is only callbacks, so that one on which nothing happens
// holds no thread.
//
// One read and one write are under way at most. Finish is called once, when no write is and no session is
// being opened (which ends with a read, and gRPC takes none after its last call); the object lives until gRPC
// has made its last call and nobody else holds it.
class FrameStream : public grpc::ServerBidiReactor<v1::StreamFramesRequest, v1::StreamFramesResponse>,
                    public StreamOutput,
                    public std::enable_shared_from_this<FrameStream> {
 public:
  // The stream keeps itself alive until it is over.
  static FrameStream* Start(CallRunner& runner);

  void Wake() override;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  explicit FrameStream(CallRunner& runner) : runner_(runner) {}

  void EndUnlessOpened();
  void HandleFirst();
  // On a query thread.
  void OpenAndRead();
  absl::Status Open();
  void HandleLater();
  void End(absl::Status status);
  // Does the next thing there is to do: a write, or Finish.
  void Pump();
  bool ChooseWrite() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  CallRunner& runner_;
  std::shared_ptr<FrameStream> self_;  // until OnDone
  v1::StreamFramesRequest request_;    // of the read under way

  Mutex mutex_;  // guards all below
  std::shared_ptr<VehicleSession> session_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<v1::SessionStarted> started_ ABSL_GUARDED_BY(mutex_);  // to be written
  v1::StreamFramesResponse response_ ABSL_GUARDED_BY(mutex_);            // of the write under way
  std::unique_ptr<absl::Status> ending_ ABSL_GUARDED_BY(mutex_);         // what to finish with
  bool first_seen_ ABSL_GUARDED_BY(mutex_) = false;
  bool opening_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace semmap::server
