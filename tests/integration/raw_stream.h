#pragma once

#include <string>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "client/grpc_status.h"
#include "semmap/v1/session_service.grpc.pb.h"

namespace semmap {

// A StreamFrames call without the client library's manners: writes anything at any time.
class RawStream {
 public:
  explicit RawStream(const std::shared_ptr<grpc::Channel>& channel) : stub_(channel) {
    context_.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
    stream_ = stub_.StreamFrames(&context_);
  }

  bool Write(const v1::StreamFramesRequest& request) { return stream_->Write(request); }
  bool WriteHello(const v1::CameraRig& rig, const std::string& map) {
    v1::StreamFramesRequest request;
    request.mutable_hello()->set_vehicle_id("car");
    request.mutable_hello()->set_map("maps/" + map);
    request.mutable_hello()->set_mode(v1::SESSION_MODE_MAP);
    *request.mutable_hello()->mutable_rig() = rig;
    return Write(request);
  }
  bool WriteFrame(const v1::Frame& frame) {
    v1::StreamFramesRequest request;
    *request.mutable_frame() = frame;
    return Write(request);
  }
  // False at the end of the stream.
  bool Read(v1::StreamFramesResponse* response) { return stream_->Read(response); }
  void CloseWriting() { stream_->WritesDone(); }
  void Cancel() { context_.TryCancel(); }

  // Reads what is left and tells how the stream ended.
  absl::Status Finish() {
    v1::StreamFramesResponse response;
    while (stream_->Read(&response)) {
    }
    return client::FromGrpc(stream_->Finish());
  }

 private:
  v1::SessionService::Stub stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamFramesRequest, v1::StreamFramesResponse>> stream_;
};

}  // namespace semmap
