#include "semmap/v1/operation.grpc.pb.h"
#include "server/rpc/services.h"
#include "server/rpc/unary_call.h"

namespace semmap::server {
namespace {

using Call = grpc::CallbackServerContext;
using Unary = grpc::ServerUnaryReactor;

class OperationService : public v1::OperationService::CallbackService {
 public:
  Unary* GetOperation(Call* call, const v1::GetOperationRequest*, v1::Operation*) override {
    return AnswerNotImplemented(call, "GetOperation");
  }
  Unary* ListOperations(Call* call, const v1::ListOperationsRequest*, v1::ListOperationsResponse*) override {
    return AnswerNotImplemented(call, "ListOperations");
  }
  Unary* WaitOperation(Call* call, const v1::WaitOperationRequest*, v1::Operation*) override {
    return AnswerNotImplemented(call, "WaitOperation");
  }
  Unary* CancelOperation(Call* call, const v1::CancelOperationRequest*, google::protobuf::Empty*) override {
    return AnswerNotImplemented(call, "CancelOperation");
  }
  Unary* DeleteOperation(Call* call, const v1::DeleteOperationRequest*, google::protobuf::Empty*) override {
    return AnswerNotImplemented(call, "DeleteOperation");
  }
};

}  // namespace

std::unique_ptr<grpc::Service> MakeOperationService(CallRunner*) {
  return std::make_unique<OperationService>();
}

}  // namespace semmap::server
