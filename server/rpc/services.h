#pragma once

#include <memory>

namespace grpc {
class Service;
}

namespace semmap::server {

class CallRunner;

// The gRPC services: thin shells that hand each call to its handler. `runner` outlives them.
std::unique_ptr<grpc::Service> MakeSessionService(CallRunner* runner);
std::unique_ptr<grpc::Service> MakeMapService(CallRunner* runner);
std::unique_ptr<grpc::Service> MakeLocalizationService(CallRunner* runner);
std::unique_ptr<grpc::Service> MakeOperationService(CallRunner* runner);

}  // namespace semmap::server
