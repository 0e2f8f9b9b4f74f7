#include "semmap/v1/session_service.grpc.pb.h"
#include "server/handlers/session_handlers.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_frames.h"
#include "server/rpc/unary_call.h"

namespace semmap::server {
namespace {

using Call = grpc::CallbackServerContext;
using Unary = grpc::ServerUnaryReactor;

class SessionService : public v1::SessionService::CallbackService {
 public:
  explicit SessionService(CallRunner* runner) : runner_(*runner) {}

  grpc::ServerBidiReactor<v1::StreamFramesRequest, v1::StreamFramesResponse>* StreamFrames(Call*) override {
    return FrameStream::Start(runner_);
  }
  Unary* GetSession(Call* call, const v1::GetSessionRequest* request, v1::Session* response) override {
    return RunUnary(runner_, call, request, response, &server::GetSession);
  }
  Unary* ListSessions(Call* call, const v1::ListSessionsRequest* request,
                      v1::ListSessionsResponse* response) override {
    return RunUnary(runner_, call, request, response, &server::ListSessions);
  }
  Unary* EndSession(Call* call, const v1::EndSessionRequest* request, v1::Session* response) override {
    return RunUnaryLater(runner_, call, request, response, &server::EndSession);
  }

 private:
  CallRunner& runner_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeSessionService(CallRunner* runner) {
  return std::make_unique<SessionService>(runner);
}

}  // namespace semmap::server
