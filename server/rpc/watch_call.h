#pragma once

#include <memory>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/server_callback.h>

#include "absl/base/thread_annotations.h"
#include "semmap/v1/map_service.pb.h"
#include "server/handlers/watch_map.h"
#include "server/rpc/call_runner.h"
#include "slam/common/mutex.h"

namespace semmap::server {

// One WatchMap: writes what its source has to tell, one message at a time, and holds no thread while there is
// nothing. Keeps itself alive until the call is over.
class WatchCall : public grpc::ServerWriteReactor<v1::WatchMapResponse>,
                  public std::enable_shared_from_this<WatchCall> {
 public:
  static WatchCall* Start(CallRunner& runner, const v1::WatchMapRequest* request);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  explicit WatchCall(CallRunner& runner) : runner_(runner) {}

  void Open(const v1::WatchMapRequest& request);
  // Something may have happened: goes on unless that is done already.
  void Wake();
  // On a query thread, one at a time.
  void Step();
  // Finishes, unless that is done.
  void End(const absl::Status& status);

  CallRunner& runner_;
  std::shared_ptr<WatchCall> self_;  // until OnDone
  bool admitted_ = false;
  std::unique_ptr<WatchSource> source_;  // of Step
  v1::WatchMapResponse message_;         // of the write under way

  Mutex mutex_;                               // guards all below
  bool busy_ ABSL_GUARDED_BY(mutex_) = true;  // opening, stepping or writing
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace semmap::server
