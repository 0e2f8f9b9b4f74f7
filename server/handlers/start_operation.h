#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "semmap/v1/operation.pb.h"
#include "server/names.h"
#include "server/service_context.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

// Starts what `start` starts, once for each request id: sent again, a request answers the same operation, as
// it is now.
template <typename Start>
absl::StatusOr<v1::Operation> StartOperation(const ServiceContext& context, const std::string& method,
                                             const std::string& request_id, Start&& start) {
  SEMMAP_RETURN_IF_ERROR(ValidateRequestId(request_id));
  if (const auto known = context.requests->Find(method, request_id)) return context.operations->Get(*known);
  SEMMAP_ASSIGN_OR_RETURN(v1::Operation operation, start());
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseOperationName("name", operation.name()));
  context.requests->Remember(method, request_id, id);
  return operation;
}

}  // namespace semmap::server
