#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

// Names of resources: "maps/{map}", "sessions/{session}", "operations/{operation}" and
// "artifacts/{artifact}". Errors are NAME_INVALID with the field's name.
namespace semmap::server {

// 1 to 63 of [A-Za-z0-9._-], the first a letter or digit.
absl::Status ValidateId(std::string_view field, std::string_view id);

// The id in a well-formed name.
absl::StatusOr<std::string> ParseMapName(std::string_view field, std::string_view name);
absl::StatusOr<std::string> ParseSessionName(std::string_view field, std::string_view name);
absl::StatusOr<std::string> ParseOperationName(std::string_view field, std::string_view name);
absl::StatusOr<std::string> ParseArtifactName(std::string_view field, std::string_view name);

std::string MapName(std::string_view map_id);
std::string SessionName(std::string_view session_id);
std::string OperationName(std::string_view operation_id);
std::string ArtifactName(std::string_view artifact_id);

// An optional text of printable ASCII that is copied into logs: FIELD_INVALID when longer or otherwise made.
absl::Status ValidateText(std::string_view field, std::string_view text, size_t max_length);
// The same of a request_id: at most 63 characters.
absl::Status ValidateRequestId(std::string_view request_id);

}  // namespace semmap::server
