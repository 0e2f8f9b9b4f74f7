#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace semmap::kill_test {

// Writes what is in a database of the present schema to a new one of schema version 1, from which semmapd
// then has all migrations to run. Every keyframe must have been stored with all its keypoints
// (storage.keyframe_keypoints), since version 1 knew no other. Packed values stay in their present form,
// which each names itself. Nobody may have the database open.
absl::Status WriteVersionOne(const std::string& present, const std::string& old);

// PRAGMA user_version of a database.
absl::StatusOr<int64_t> SchemaVersion(const std::string& path);

}  // namespace semmap::kill_test
