#pragma once

#include <functional>
#include <utility>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/server_callback.h>

#include "absl/status/statusor.h"
#include "server/rpc/call_runner.h"
#include "server/rpc/grpc_status.h"

namespace semmap::server {

// Runs a handler for one unary call and sends what it returns.
template <typename Request, typename Response>
grpc::ServerUnaryReactor* RunUnary(CallRunner& runner, grpc::CallbackServerContext* call,
                                   const Request* request, Response* response,
                                   absl::StatusOr<Response> (*handler)(const ServiceContext&,
                                                                       const Request&)) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  if (const absl::Status admitted = runner.Admit(); !admitted.ok()) {
    reactor->Finish(ToGrpc(admitted));
    return reactor;
  }
  // Request and response stay until Finish.
  runner.Run([&runner, call, request, response, reactor, handler] {
    absl::Status status = absl::CancelledError("the caller has gone");
    if (!call->IsCancelled()) {
      auto result = handler(runner.context(), *request);
      status = result.status();
      if (result.ok()) *response = std::move(result).value();
    }
    runner.Release();
    reactor->Finish(ToGrpc(status));
  });
  return reactor;
}

// The same for a handler that answers later, by calling what it is given once.
template <typename Request, typename Response>
grpc::ServerUnaryReactor* RunUnaryLater(CallRunner& runner, grpc::CallbackServerContext* call,
                                        const Request* request, Response* response,
                                        void (*handler)(const ServiceContext&, const Request&,
                                                        std::function<void(absl::StatusOr<Response>)>)) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  if (const absl::Status admitted = runner.Admit(); !admitted.ok()) {
    reactor->Finish(ToGrpc(admitted));
    return reactor;
  }
  runner.Run([&runner, request, response, reactor, handler] {
    handler(runner.context(), *request, [&runner, response, reactor](absl::StatusOr<Response> result) {
      if (result.ok()) *response = std::move(result).value();
      runner.Release();
      reactor->Finish(ToGrpc(result.status()));
    });
  });
  return reactor;
}

}  // namespace semmap::server
