#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"

namespace semmap::server {

// A status as it goes over the wire: code, message and google.rpc.Status with the reason. A status that came
// without a reason is a defect and leaves as INTERNAL.
grpc::Status ToGrpc(const absl::Status& status);

}  // namespace semmap::server
