#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"
#include "semmap/v1/error_reason.pb.h"

// The one table of reasons for which calls fail. A status that leaves the server carries one of them as
// google.rpc.ErrorInfo, kept in the status as a payload until it is sent.
namespace semmap::server {

using ErrorMetadata = std::initializer_list<std::pair<std::string_view, std::string>>;

// A status with the reason's code and the reason as its payload.
absl::Status Error(v1::ErrorReason reason, std::string_view message, ErrorMetadata metadata = {});

// FIELD_INVALID, "<field> <what>": `what` says what the field must be.
absl::Status FieldInvalid(std::string_view field, std::string_view what);

// "This version does not do that."
absl::Status NotImplemented(std::string_view feature);

// `status` with its reason, if it has none yet; its code becomes the reason's. OK stays OK.
absl::Status WithReason(const absl::Status& status, v1::ErrorReason reason, ErrorMetadata metadata = {});

// As it goes over the wire: code, message and the reason as a detail. A status that came without a reason is
// a defect and becomes INTERNAL.
google::rpc::Status ToRpcStatus(const absl::Status& status);

// Gives a status of the store that reason which follows from its code. NOT_FOUND and ALREADY_EXISTS mean
// different things in different calls: give those a reason before.
absl::Status FromStore(const absl::Status& status);

// UNSPECIFIED when there is none.
v1::ErrorReason ReasonOf(const absl::Status& status);

// "MAP_NOT_FOUND".
std::string ReasonName(v1::ErrorReason reason);

// Status code of a reason; kUnknown for values that are not in the table.
absl::StatusCode CodeOf(v1::ErrorReason reason);

// Under this URL the serialized google.rpc.ErrorInfo is a payload of the status.
inline constexpr std::string_view kErrorInfoUrl = "type.googleapis.com/google.rpc.ErrorInfo";

}  // namespace semmap::server
