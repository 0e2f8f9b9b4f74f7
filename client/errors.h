#pragma once

#include <string>

#include "absl/status/status.h"

namespace semmap::client {

// What the service gave as the cause of a failed call: the name of a semmap.v1.ErrorReason without its
// prefix, such as "MAP_NOT_FOUND"; empty for failures that did not come from the service (connection,
// deadline).
std::string ErrorReason(const absl::Status& status);

// The value that belongs to the reason, such as ErrorMetadata(status, "field"); empty if there is none.
std::string ErrorMetadata(const absl::Status& status, const std::string& key);

}  // namespace semmap::client
