#include "client/grpc_status.h"

#include "google/rpc/status.pb.h"

namespace semmap::client {
namespace {

void AddDetails(const google::rpc::Status& details, absl::Status* status) {
  for (const auto& detail : details.details())
    status->SetPayload(detail.type_url(), absl::Cord(detail.value()));
}

}  // namespace

absl::Status FromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  absl::Status result(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
  google::rpc::Status details;
  if (details.ParseFromString(status.error_details())) AddDetails(details, &result);
  return result;
}

absl::Status FromRpcStatus(const google::rpc::Status& status) {
  absl::Status result(static_cast<absl::StatusCode>(status.code()), status.message());
  AddDetails(status, &result);
  return result;
}

}  // namespace semmap::client
