#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"

namespace semmap::client {

// The status of a call with the reason that the server sent, if it sent one, as a payload (see errors.h).
absl::Status FromGrpc(const grpc::Status& status);
// The same for a status inside a message.
absl::Status FromRpcStatus(const google::rpc::Status& status);

}  // namespace semmap::client
