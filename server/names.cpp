#include "server/names.h"

#include <algorithm>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

constexpr size_t kMaxIdLength = 63;
constexpr std::string_view kMapPrefix = "maps/";
constexpr std::string_view kSessionPrefix = "sessions/";
constexpr std::string_view kOperationPrefix = "operations/";
constexpr std::string_view kArtifactPrefix = "artifacts/";

bool IsAlphanumeric(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

bool IsIdCharacter(char c) { return IsAlphanumeric(c) || c == '.' || c == '_' || c == '-'; }

absl::Status NameInvalid(std::string_view field, std::string_view expected) {
  return Error(v1::ERROR_REASON_NAME_INVALID, std::string(field).append(" must be ").append(expected),
               {{"field", std::string(field)}});
}

absl::StatusOr<std::string> ParseName(std::string_view field, std::string_view prefix,
                                      std::string_view name) {
  if (!name.starts_with(prefix)) {
    return NameInvalid(field, std::string(prefix).append("{id}"));
  }
  const std::string_view id = name.substr(prefix.size());
  if (absl::Status status = ValidateId(field, id); !status.ok()) return status;
  return std::string(id);
}

}  // namespace

absl::Status ValidateId(std::string_view field, std::string_view id) {
  const bool well_formed = !id.empty() && id.size() <= kMaxIdLength && IsAlphanumeric(id.front()) &&
                           std::all_of(id.begin(), id.end(), IsIdCharacter);
  if (well_formed) return absl::OkStatus();
  return NameInvalid(field, "1 to 63 letters, digits, '.', '_' or '-', the first a letter or digit");
}

absl::StatusOr<std::string> ParseMapName(std::string_view field, std::string_view name) {
  return ParseName(field, kMapPrefix, name);
}

absl::StatusOr<std::string> ParseSessionName(std::string_view field, std::string_view name) {
  return ParseName(field, kSessionPrefix, name);
}

absl::StatusOr<std::string> ParseOperationName(std::string_view field, std::string_view name) {
  return ParseName(field, kOperationPrefix, name);
}

absl::StatusOr<std::string> ParseArtifactName(std::string_view field, std::string_view name) {
  return ParseName(field, kArtifactPrefix, name);
}

std::string MapName(std::string_view map_id) { return std::string(kMapPrefix).append(map_id); }

std::string SessionName(std::string_view session_id) {
  return std::string(kSessionPrefix).append(session_id);
}

std::string OperationName(std::string_view operation_id) {
  return std::string(kOperationPrefix).append(operation_id);
}

std::string ArtifactName(std::string_view artifact_id) {
  return std::string(kArtifactPrefix).append(artifact_id);
}

absl::Status ValidateText(std::string_view field, std::string_view text, size_t max_length) {
  const bool printable = std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (printable && text.size() <= max_length) return absl::OkStatus();
  return FieldInvalid(field,
                      "must be printable ASCII of at most " + std::to_string(max_length) + " characters");
}

absl::Status ValidateRequestId(std::string_view request_id) {
  constexpr size_t kMaxRequestId = 63;
  return ValidateText("request_id", request_id, kMaxRequestId);
}

}  // namespace semmap::server
