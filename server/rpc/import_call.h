#pragma once

#include <memory>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/server_callback.h>

#include "absl/base/thread_annotations.h"
#include "semmap/v1/map_service.pb.h"
#include "server/map_upload.h"
#include "server/rpc/call_runner.h"
#include "slam/common/mutex.h"

namespace semmap::server {

// Takes in a map file piece by piece; the next piece is asked for when the one before is on disk. An upload
// that falls silent is ended after the pause between keepalive pings. Keeps itself alive until it is over.
class ImportCall : public grpc::ServerReadReactor<v1::ImportMapRequest>,
                   public std::enable_shared_from_this<ImportCall> {
 public:
  static ImportCall* Start(CallRunner& runner, grpc::CallbackServerContext* call, v1::Operation* response);

  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  ImportCall(CallRunner& runner, grpc::CallbackServerContext* call, v1::Operation* response)
      : runner_(runner), call_(call), response_(response) {}

  void Begin();
  void ReadNext();
  absl::Status Take();
  absl::Status Complete();
  void WatchSilence(uint64_t reads);
  void EndIfSilentSince(uint64_t reads);

  CallRunner& runner_;
  grpc::CallbackServerContext* const call_;
  v1::Operation* const response_;
  std::shared_ptr<ImportCall> self_;  // until OnDone
  // Of one callback or task at a time.
  bool admitted_ = false;
  v1::ImportMapRequest request_;
  std::unique_ptr<MapUpload> upload_;

  Mutex mutex_;  // guards all below
  uint64_t reads_ ABSL_GUARDED_BY(mutex_) = 0;
  bool reading_ ABSL_GUARDED_BY(mutex_) = false;
  bool over_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace semmap::server
