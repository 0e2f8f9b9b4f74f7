#pragma once

#include <functional>

#include "absl/status/statusor.h"
#include "google/protobuf/empty.pb.h"
#include "semmap/v1/operation.pb.h"
#include "server/service_context.h"

// OperationService; as map_handlers.h.
namespace semmap::server {

absl::StatusOr<v1::Operation> GetOperation(const ServiceContext& context,
                                           const v1::GetOperationRequest& request);
absl::StatusOr<v1::ListOperationsResponse> ListOperations(const ServiceContext& context,
                                                          const v1::ListOperationsRequest& request);
absl::StatusOr<google::protobuf::Empty> CancelOperation(const ServiceContext& context,
                                                        const v1::CancelOperationRequest& request);
absl::StatusOr<google::protobuf::Empty> DeleteOperation(const ServiceContext& context,
                                                        const v1::DeleteOperationRequest& request);

// Holds no thread while it waits: `done` is called, once, when the operation is done or the time is over.
void WaitOperation(const ServiceContext& context, const v1::WaitOperationRequest& request,
                   std::function<void(absl::StatusOr<v1::Operation>)> done);

}  // namespace semmap::server
