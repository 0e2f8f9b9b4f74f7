#include "server/map_description.h"

#include <algorithm>
#include <cmath>

#include "server/error_reasons.h"
#include "server/pose_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr int64_t kMaxDisplayName = 256;
constexpr int kMaxLabels = 64;
constexpr int64_t kMaxKey = 63;
constexpr int64_t kMaxValue = 255;

// Of UTF-8, which protobuf has checked.
int64_t Characters(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

}  // namespace

absl::Status CheckDisplayName(const std::string& display_name) {
  if (Characters(display_name) <= kMaxDisplayName) return absl::OkStatus();
  return FieldInvalid("map.display_name", "must be at most 256 characters");
}

absl::StatusOr<storage::Labels> ReadLabels(const v1::Map& map) {
  if (map.labels_size() > kMaxLabels) return FieldInvalid("map.labels", "must be at most 64");
  storage::Labels labels;
  for (const auto& [key, value] : map.labels()) {
    if (key.empty() || Characters(key) > kMaxKey || Characters(value) > kMaxValue) {
      return FieldInvalid("map.labels", "must have keys of 1 to 63 and values of at most 255 characters");
    }
    labels[key] = value;
  }
  return labels;
}

absl::StatusOr<storage::GeoAnchor> ReadAnchor(const v1::GeoAnchor& anchor) {
  storage::GeoAnchor result;
  result.latitude_deg = anchor.origin().latitude_deg();
  result.longitude_deg = anchor.origin().longitude_deg();
  result.altitude_m = anchor.origin().altitude_m();
  const bool on_earth = std::abs(result.latitude_deg) <= 90 && std::abs(result.longitude_deg) <= 180 &&
                        std::isfinite(result.altitude_m);
  if (!anchor.has_origin() || !on_earth) return FieldInvalid("map.anchor.origin", "is no place on Earth");
  if (!anchor.has_enu_from_map()) return FieldInvalid("map.anchor.enu_from_map", "is missing");
  const double scale = anchor.enu_from_map().scale();
  if (!std::isfinite(scale) || scale < 0) return FieldInvalid("map.anchor.enu_from_map", "has no scale");
  result.enu_from_map.scale = scale == 0 ? 1 : scale;
  auto pose = FromProto(anchor.enu_from_map().pose());
  if (!pose.ok()) return WithReason(pose.status(), v1::ERROR_REASON_FIELD_INVALID);
  result.enu_from_map.rigid = *pose;
  return result;
}

}  // namespace semmap::server
