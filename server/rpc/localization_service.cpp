#include "semmap/v1/localization_service.grpc.pb.h"
#include "server/handlers/localization_handlers.h"
#include "server/map_cache.h"
#include "server/rpc/call_runner.h"
#include "server/rpc/grpc_status.h"
#include "server/rpc/services.h"

namespace semmap::server {
namespace {

// One call. Waits for its map without a thread; whoever has gone meanwhile, or whose deadline is over, costs
// no more work. Request and response stay until Finish.
class RelocalizeCall : public std::enable_shared_from_this<RelocalizeCall> {
 public:
  RelocalizeCall(CallRunner* runner, grpc::CallbackServerContext* call, const v1::RelocalizeRequest* request,
                 v1::RelocalizeResponse* response)
      : runner_(*runner),
        call_(call),
        reactor_(call->DefaultReactor()),
        request_(*request),
        response_(response) {}

  grpc::ServerUnaryReactor* Start() {
    // Not the member: the call may be over, and this object with it, before this returns.
    grpc::ServerUnaryReactor* const reactor = reactor_;
    if (const absl::Status admitted = runner_.Admit(); !admitted.ok()) {
      reactor->Finish(ToGrpc(admitted));
    } else {
      runner_.Run([self = shared_from_this()] { self->Prepare(); });
    }
    return reactor;
  }

 private:
  void Prepare() {
    auto task = PrepareRelocalize(runner_.context(), request_);
    if (!task.ok()) {
      Finish(task.status());
      return;
    }
    task_ = std::move(task).value();
    runner_.context().maps->Get(task_.map,
                                [self = shared_from_this()](absl::StatusOr<MapCache::Snapshot> map) {
                                  if (!map.ok()) {
                                    self->Finish(map.status());
                                    return;
                                  }
                                  self->runner_.Run([self, map = *std::move(map)] { self->Look(*map); });
                                });
  }

  void Look(const MapSnapshot& map) {
    if (call_->IsCancelled()) {
      Finish(absl::CancelledError("the caller has gone"));
      return;
    }
    auto response = Relocalize(runner_.context(), request_, task_, map);
    if (response.ok()) *response_ = *std::move(response);
    Finish(response.status());
  }

  void Finish(const absl::Status& status) {
    runner_.Release();
    reactor_->Finish(ToGrpc(status));
  }

  CallRunner& runner_;
  grpc::CallbackServerContext* const call_;
  grpc::ServerUnaryReactor* const reactor_;
  const v1::RelocalizeRequest& request_;
  v1::RelocalizeResponse* const response_;
  RelocalizeTask task_;
};

class LocalizationService : public v1::LocalizationService::CallbackService {
 public:
  explicit LocalizationService(CallRunner* runner) : runner_(runner) {}

  grpc::ServerUnaryReactor* Relocalize(grpc::CallbackServerContext* call,
                                       const v1::RelocalizeRequest* request,
                                       v1::RelocalizeResponse* response) override {
    return std::make_shared<RelocalizeCall>(runner_, call, request, response)->Start();
  }

 private:
  CallRunner* const runner_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeLocalizationService(CallRunner* runner) {
  return std::make_unique<LocalizationService>(runner);
}

}  // namespace semmap::server
