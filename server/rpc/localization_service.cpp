#include "semmap/v1/localization_service.grpc.pb.h"
#include "server/rpc/services.h"
#include "server/rpc/unary_call.h"

namespace semmap::server {
namespace {

class LocalizationService : public v1::LocalizationService::CallbackService {
 public:
  grpc::ServerUnaryReactor* Relocalize(grpc::CallbackServerContext* call, const v1::RelocalizeRequest*,
                                       v1::RelocalizeResponse*) override {
    return AnswerNotImplemented(call, "Relocalize");
  }
};

}  // namespace

std::unique_ptr<grpc::Service> MakeLocalizationService(CallRunner*) {
  return std::make_unique<LocalizationService>();
}

}  // namespace semmap::server
