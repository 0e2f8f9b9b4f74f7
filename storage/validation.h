#pragma once

#include "absl/status/status.h"
#include "slam/map/map_delta.h"
#include "storage/map_store.h"

// What any backend refuses before it touches its database: values that could not be stored exactly or read
// back. Whether the things named exist is for the backend to see. All answer OK or INVALID_ARGUMENT naming
// the value.
namespace semmap::storage {

// Ids of keyframes and points are below this, so that (map, thing) fits one 64-bit key of a spatial index.
constexpr uint64_t kIdLimit = uint64_t{1} << 40;
constexpr uint64_t kMapIdLimit = uint64_t{1} << 23;

absl::Status ValidateDelta(const MapDelta& delta);
absl::Status ValidateNewMap(const NewMap& map);
absl::Status ValidateNewSession(const NewSession& session);
absl::Status ValidateAnchor(const GeoAnchor& anchor);
// Well-formed UTF-8 (RFC 3629): other text cannot be sent to anybody.
bool IsUtf8(std::string_view text);
absl::Status ValidateDescription(const std::string& display_name, const Labels& labels);
absl::Status ValidateChanges(const MapChanges& changes);
absl::Status ValidateCounters(const SessionCounters& counters);
// Not empty, finite.
absl::Status ValidateBox(const std::optional<Eigen::AlignedBox3d>& box);

}  // namespace semmap::storage
