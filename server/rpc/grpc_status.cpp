#include "server/rpc/grpc_status.h"

#include <string>

#include "google/rpc/status.pb.h"
#include "server/error_reasons.h"

namespace semmap::server {

grpc::Status ToGrpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const absl::Status reasoned = WithReason(status, v1::ERROR_REASON_INTERNAL);
  google::rpc::Status details;
  details.set_code(static_cast<int>(reasoned.code()));
  details.set_message(std::string(reasoned.message()));
  google::protobuf::Any* info = details.add_details();
  info->set_type_url(std::string(kErrorInfoUrl));
  info->set_value(std::string(*reasoned.GetPayload(kErrorInfoUrl.data())));
  return grpc::Status(static_cast<grpc::StatusCode>(reasoned.code()), details.message(),
                      details.SerializeAsString());
}

}  // namespace semmap::server
