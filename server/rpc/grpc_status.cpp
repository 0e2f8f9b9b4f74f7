#include "server/rpc/grpc_status.h"

#include <string>

#include "google/rpc/status.pb.h"
#include "server/error_reasons.h"

namespace semmap::server {

grpc::Status ToGrpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const google::rpc::Status details = ToRpcStatus(status);
  return grpc::Status(static_cast<grpc::StatusCode>(details.code()), details.message(),
                      details.SerializeAsString());
}

}  // namespace semmap::server
