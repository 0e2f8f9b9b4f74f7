#include "semmap/v1/operation.grpc.pb.h"
#include "server/handlers/operation_handlers.h"
#include "server/rpc/services.h"
#include "server/rpc/unary_call.h"

namespace semmap::server {
namespace {

using Call = grpc::CallbackServerContext;
using Unary = grpc::ServerUnaryReactor;

class OperationService : public v1::OperationService::CallbackService {
 public:
  explicit OperationService(CallRunner* runner) : runner_(*runner) {}

  Unary* GetOperation(Call* call, const v1::GetOperationRequest* request, v1::Operation* response) override {
    return RunUnary(runner_, call, request, response, &server::GetOperation);
  }
  Unary* ListOperations(Call* call, const v1::ListOperationsRequest* request,
                        v1::ListOperationsResponse* response) override {
    return RunUnary(runner_, call, request, response, &server::ListOperations);
  }
  Unary* WaitOperation(Call* call, const v1::WaitOperationRequest* request,
                       v1::Operation* response) override {
    return RunUnaryLater(runner_, call, request, response, &server::WaitOperation);
  }
  Unary* CancelOperation(Call* call, const v1::CancelOperationRequest* request,
                         google::protobuf::Empty* response) override {
    return RunUnary(runner_, call, request, response, &server::CancelOperation);
  }
  Unary* DeleteOperation(Call* call, const v1::DeleteOperationRequest* request,
                         google::protobuf::Empty* response) override {
    return RunUnary(runner_, call, request, response, &server::DeleteOperation);
  }

 private:
  CallRunner& runner_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeOperationService(CallRunner* runner) {
  return std::make_unique<OperationService>(runner);
}

}  // namespace semmap::server
