#include "server/error_reasons.h"

#include <array>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "google/rpc/error_details.pb.h"

namespace semmap::server {
namespace {

using absl::StatusCode;

struct Entry {
  v1::ErrorReason reason;
  StatusCode code;
};

constexpr Entry kReasons[] = {
    {v1::ERROR_REASON_FIELD_INVALID, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_NAME_INVALID, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_PAGE_TOKEN_INVALID, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_AREA_INVALID, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_RIG_INVALID, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_MESSAGE_UNEXPECTED, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_SEQUENCE_NOT_INCREASING, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_TIME_NOT_INCREASING, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_IMAGE_MISSING, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_IMAGE_UNEXPECTED, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_IMAGE_ENCODING_UNSUPPORTED, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_IMAGE_CORRUPT, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_IMAGE_SIZE_MISMATCH, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_IMAGE_TOO_LARGE, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_FILE_INVALID, StatusCode::kInvalidArgument},
    {v1::ERROR_REASON_MAP_NOT_FOUND, StatusCode::kNotFound},
    {v1::ERROR_REASON_SESSION_NOT_FOUND, StatusCode::kNotFound},
    {v1::ERROR_REASON_SESSION_NOT_RESUMABLE, StatusCode::kNotFound},
    {v1::ERROR_REASON_OPERATION_NOT_FOUND, StatusCode::kNotFound},
    {v1::ERROR_REASON_ARTIFACT_NOT_FOUND, StatusCode::kNotFound},
    {v1::ERROR_REASON_MAP_EXISTS, StatusCode::kAlreadyExists},
    {v1::ERROR_REASON_MAP_NOT_EMPTY, StatusCode::kAlreadyExists},
    {v1::ERROR_REASON_MAP_IN_USE, StatusCode::kFailedPrecondition},
    {v1::ERROR_REASON_MAP_NOT_ANCHORED, StatusCode::kFailedPrecondition},
    {v1::ERROR_REASON_MAPS_DO_NOT_OVERLAP, StatusCode::kFailedPrecondition},
    {v1::ERROR_REASON_MAP_EMPTY, StatusCode::kFailedPrecondition},
    {v1::ERROR_REASON_MAPS_DIFFER_IN_CAMERAS, StatusCode::kFailedPrecondition},
    {v1::ERROR_REASON_SESSION_RESUMED_ELSEWHERE, StatusCode::kAborted},
    {v1::ERROR_REASON_SESSION_ENDED_BY_OPERATOR, StatusCode::kAborted},
    {v1::ERROR_REASON_ETAG_MISMATCH, StatusCode::kAborted},
    {v1::ERROR_REASON_OPERATION_INTERRUPTED, StatusCode::kAborted},
    {v1::ERROR_REASON_TOO_MANY_SESSIONS, StatusCode::kResourceExhausted},
    {v1::ERROR_REASON_CREDIT_EXCEEDED, StatusCode::kResourceExhausted},
    {v1::ERROR_REASON_WATCHER_TOO_SLOW, StatusCode::kResourceExhausted},
    {v1::ERROR_REASON_TOO_MANY_MAPS, StatusCode::kResourceExhausted},
    {v1::ERROR_REASON_TOO_MANY_REQUESTS, StatusCode::kResourceExhausted},
    {v1::ERROR_REASON_MAP_TOO_LARGE, StatusCode::kResourceExhausted},
    {v1::ERROR_REASON_FILES_TOO_LARGE, StatusCode::kResourceExhausted},
    {v1::ERROR_REASON_SHUTTING_DOWN, StatusCode::kUnavailable},
    {v1::ERROR_REASON_STORE_UNAVAILABLE, StatusCode::kUnavailable},
    {v1::ERROR_REASON_NOT_IMPLEMENTED, StatusCode::kUnimplemented},
    {v1::ERROR_REASON_CREDENTIALS_INVALID, StatusCode::kUnauthenticated},
    {v1::ERROR_REASON_ROLE_NOT_ALLOWED, StatusCode::kPermissionDenied},
    {v1::ERROR_REASON_CHECKSUM_MISMATCH, StatusCode::kDataLoss},
    {v1::ERROR_REASON_STORE_CORRUPT, StatusCode::kDataLoss},
    {v1::ERROR_REASON_INTERNAL, StatusCode::kInternal},
};

v1::ErrorReason ReasonOfStoreCode(StatusCode code) {
  switch (code) {
    case StatusCode::kInvalidArgument:
      return v1::ERROR_REASON_FIELD_INVALID;
    case StatusCode::kNotFound:
      return v1::ERROR_REASON_MAP_NOT_FOUND;
    case StatusCode::kUnavailable:
    case StatusCode::kResourceExhausted:
      return v1::ERROR_REASON_STORE_UNAVAILABLE;
    case StatusCode::kDataLoss:
      return v1::ERROR_REASON_STORE_CORRUPT;
    default:
      return v1::ERROR_REASON_INTERNAL;
  }
}

}  // namespace

absl::StatusCode CodeOf(v1::ErrorReason reason) {
  for (const Entry& entry : kReasons) {
    if (entry.reason == reason) return entry.code;
  }
  return StatusCode::kUnknown;
}

std::string ReasonName(v1::ErrorReason reason) {
  return std::string(absl::StripPrefix(v1::ErrorReason_Name(reason), "ERROR_REASON_"));
}

absl::Status Error(v1::ErrorReason reason, std::string_view message, ErrorMetadata metadata) {
  google::rpc::ErrorInfo info;
  info.set_reason(ReasonName(reason));
  info.set_domain("semmap");
  for (const auto& [key, value] : metadata) (*info.mutable_metadata())[std::string(key)] = value;
  absl::Status status(CodeOf(reason), absl::string_view(message.data(), message.size()));
  status.SetPayload(kErrorInfoUrl.data(), absl::Cord(info.SerializeAsString()));
  return status;
}

absl::Status FieldInvalid(std::string_view field, std::string_view what) {
  return Error(v1::ERROR_REASON_FIELD_INVALID, std::string(field).append(" ").append(what), {{"field", std::string(field)}});
}

absl::Status NotImplemented(std::string_view feature) {
  return Error(v1::ERROR_REASON_NOT_IMPLEMENTED,
               std::string(feature).append(" is not implemented by this version of the server"),
               {{"feature", std::string(feature)}});
}

absl::Status WithReason(const absl::Status& status, v1::ErrorReason reason, ErrorMetadata metadata) {
  if (status.ok() || status.GetPayload(kErrorInfoUrl.data()).has_value()) return status;
  return Error(reason, std::string(status.message()), metadata);
}

google::rpc::Status ToRpcStatus(const absl::Status& status) {
  const absl::Status reasoned = WithReason(status, v1::ERROR_REASON_INTERNAL);
  google::rpc::Status details;
  details.set_code(static_cast<int>(reasoned.code()));
  details.set_message(std::string(reasoned.message()));
  google::protobuf::Any* info = details.add_details();
  info->set_type_url(std::string(kErrorInfoUrl));
  info->set_value(std::string(*reasoned.GetPayload(kErrorInfoUrl.data())));
  return details;
}

absl::Status FromStore(const absl::Status& status) {
  return WithReason(status, ReasonOfStoreCode(status.code()));
}

v1::ErrorReason ReasonOf(const absl::Status& status) {
  const auto payload = status.GetPayload(kErrorInfoUrl.data());
  google::rpc::ErrorInfo info;
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  if (!payload.has_value() || !info.ParseFromString(std::string(*payload))) return reason;
  v1::ErrorReason_Parse(absl::StrCat("ERROR_REASON_", info.reason()), &reason);
  return reason;
}

}  // namespace semmap::server
