#include "storage/validation.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/appearance_codec.h"
#include "storage/feature_codec.h"

namespace semmap::storage {
namespace {

constexpr size_t kMaxMapName = 63;
constexpr size_t kMaxDisplayName = 1024;
constexpr size_t kMaxLabels = 64;
constexpr size_t kMaxLabelKey = 252;
constexpr size_t kMaxLabelValue = 1020;
constexpr size_t kMaxSessionName = 128;
constexpr size_t kMaxVehicleId = 256;
constexpr double kUnitTolerance = 1e-6;

template <typename... Parts>
absl::Status Refuse(const Parts&... parts) {
  return absl::InvalidArgumentError(absl::StrCat(parts...));
}

bool IsStorable(const SE3& pose) {
  return pose.IsFinite() && std::abs(pose.rotation().norm() - 1.0) <= kUnitTolerance;
}

template <typename Id>
bool IsStorable(Id id) {
  return id.IsValid() && id.value() < kIdLimit;
}

// Sequences, versions and counts are stored as signed integers.
bool FitsSigned(uint64_t value) {
  return value <= static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
}

bool IsFinite(const Keypoint& keypoint) {
  return std::isfinite(keypoint.x) && std::isfinite(keypoint.y) && std::isfinite(keypoint.right_x) &&
         std::isfinite(keypoint.depth) && std::isfinite(keypoint.angle);
}

absl::Status ValidateKeyFrame(const KeyFrameRecord& keyframe) {
  const uint64_t id = keyframe.id.value();
  if (!IsStorable(keyframe.id)) return Refuse("added keyframe ", id, ": id out of range");
  if (keyframe.parent.IsValid() && (!IsStorable(keyframe.parent) || keyframe.parent == keyframe.id)) {
    return Refuse("added keyframe ", id, ": bad parent ", keyframe.parent.value());
  }
  if (!FitsSigned(keyframe.sequence)) return Refuse("added keyframe ", id, ": sequence out of range");
  if (!IsStorable(keyframe.map_from_camera)) return Refuse("added keyframe ", id, ": pose is not finite");
  if (keyframe.features == nullptr) return Refuse("added keyframe ", id, ": no features");
  const FrameFeatures& features = *keyframe.features;
  if (features.keypoints.size() != features.descriptors.size() || features.size() > kMaxKeypoints) {
    return Refuse("added keyframe ", id, ": ", features.keypoints.size(), " keypoints, ",
                  features.descriptors.size(), " descriptors");
  }
  if (!std::all_of(features.keypoints.begin(), features.keypoints.end(), IsFinite)) {
    return Refuse("added keyframe ", id, ": a keypoint is not finite");
  }
  return absl::OkStatus();
}

absl::Status ValidateMove(const KeyFramePose& moved) {
  const uint64_t id = moved.id.value();
  if (!IsStorable(moved.id)) return Refuse("moved keyframe ", id, ": id out of range");
  if (moved.parent.IsValid() && (!IsStorable(moved.parent) || moved.parent == moved.id)) {
    return Refuse("moved keyframe ", id, ": bad parent ", moved.parent.value());
  }
  if (!IsStorable(moved.map_from_camera)) return Refuse("moved keyframe ", id, ": pose is not finite");
  if (!std::isfinite(moved.rescale) || moved.rescale <= 0) {
    return Refuse("moved keyframe ", id, ": rescale is not a positive number");
  }
  return absl::OkStatus();
}

absl::Status ValidatePoint(const MapPointRecord& point) {
  const uint64_t id = point.id.value();
  if (!IsStorable(point.id)) return Refuse("map point ", id, ": id out of range");
  if (!point.position_in_map.allFinite()) return Refuse("map point ", id, ": position is not finite");
  if (!point.normal.allFinite()) return Refuse("map point ", id, ": normal is not finite");
  if (!std::isfinite(point.min_distance) || !std::isfinite(point.max_distance)) {
    return Refuse("map point ", id, ": distance is not finite");
  }
  if (!std::isfinite(point.class_confidence)) return Refuse("map point ", id, ": confidence is not finite");
  if (point.reference_keyframe.value() >= kIdLimit)
    return Refuse("map point ", id, ": bad reference keyframe");
  if (point.votes.size() > kMaxClassVotes) return Refuse("map point ", id, ": too many class votes");
  return absl::OkStatus();
}

absl::Status ValidateObservations(const KeyFrameObservations& observations) {
  const uint64_t id = observations.id.value();
  if (!IsStorable(observations.id)) return Refuse("observations of keyframe ", id, ": id out of range");
  if (observations.point_of_keypoint.size() > kMaxKeypoints) {
    return Refuse("observations of keyframe ", id, ": more than ", kMaxKeypoints);
  }
  const auto in_range = [](MapPointId point) { return point.value() < kIdLimit; };
  if (!std::all_of(observations.point_of_keypoint.begin(), observations.point_of_keypoint.end(), in_range)) {
    return Refuse("observations of keyframe ", id, ": point id out of range");
  }
  return absl::OkStatus();
}

absl::Status ValidateRemoval(const RemovedKeyFrame& removal) {
  if (!IsStorable(removal.removed) || !IsStorable(removal.heir) || removal.removed == removal.heir) {
    return Refuse("removed keyframe ", removal.removed.value(), ": bad heir ", removal.heir.value());
  }
  if (!IsStorable(removal.heir_from_removed)) {
    return Refuse("removed keyframe ", removal.removed.value(), ": pose is not finite");
  }
  return absl::OkStatus();
}

absl::Status ValidateFrame(const FramePose& frame) {
  if (!FitsSigned(frame.sequence)) return Refuse("frame ", frame.sequence, ": sequence out of range");
  if (!IsStorable(frame.reference_keyframe))
    return Refuse("frame ", frame.sequence, ": no reference keyframe");
  if (!IsStorable(frame.keyframe_from_camera))
    return Refuse("frame ", frame.sequence, ": pose is not finite");
  return absl::OkStatus();
}

template <typename Members, typename Validate>
absl::Status ValidateAll(const Members& members, Validate&& validate) {
  for (const auto& member : members) SEMMAP_RETURN_IF_ERROR(validate(member));
  return absl::OkStatus();
}

absl::Status ValidateRigValues(const CameraRig& rig) {
  SEMMAP_RETURN_IF_ERROR(ValidateRig(rig));
  return IsStorable(rig.body_from_camera) ? absl::OkStatus() : Refuse("rig: body_from_camera is not finite");
}

}  // namespace

absl::Status ValidateDelta(const MapDelta& delta) {
  if (!FitsSigned(delta.version)) return Refuse("delta version out of range");
  SEMMAP_RETURN_IF_ERROR(ValidateAll(delta.added_keyframes, ValidateKeyFrame));
  SEMMAP_RETURN_IF_ERROR(ValidateAll(delta.moved_keyframes, ValidateMove));
  SEMMAP_RETURN_IF_ERROR(ValidateAll(delta.upserted_points, ValidatePoint));
  SEMMAP_RETURN_IF_ERROR(ValidateAll(delta.observations, ValidateObservations));
  SEMMAP_RETURN_IF_ERROR(ValidateAll(delta.removed_keyframes, ValidateRemoval));
  return ValidateAll(delta.frames, ValidateFrame);
}

absl::Status ValidateMapName(std::string_view name) {
  const auto allowed = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-';
  };
  if (name.empty() || name.size() > kMaxMapName ||
      !absl::ascii_isalnum(static_cast<unsigned char>(name.front())) ||
      !std::all_of(name.begin(), name.end(), allowed)) {
    return Refuse("map name must be 1 to 63 of a-z A-Z 0-9 _ . - and begin with a letter or digit");
  }
  return absl::OkStatus();
}

absl::Status ValidateNewMap(const NewMap& map) {
  SEMMAP_RETURN_IF_ERROR(ValidateMapName(map.name));
  SEMMAP_RETURN_IF_ERROR(ValidateDescription(map.display_name, map.labels));
  if (map.anchor.has_value()) SEMMAP_RETURN_IF_ERROR(ValidateAnchor(*map.anchor));
  return ValidateRigValues(map.rig);
}

bool IsUtf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const auto byte = [&](size_t at) { return static_cast<uint8_t>(text[at]); };
    const uint8_t lead = byte(i++);
    if (lead < 0x80) continue;
    const int more = lead >= 0xF0 ? 3 : lead >= 0xE0 ? 2 : 1;
    if (lead < 0xC2 || lead > 0xF4 || text.size() - i < static_cast<size_t>(more)) return false;
    uint32_t code = lead & (0x3F >> more);
    for (int k = 0; k < more; ++k, ++i) {
      if ((byte(i) & 0xC0) != 0x80) return false;
      code = code << 6 | (byte(i) & 0x3FU);
    }
    constexpr uint32_t kShortest[] = {0, 0x80, 0x800, 0x10000};
    const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
    if (code < kShortest[more] || surrogate || code > 0x10FFFF) return false;
  }
  return true;
}

absl::Status ValidateDescription(const std::string& display_name, const Labels& labels) {
  if (!IsUtf8(display_name)) return Refuse("display name is not UTF-8");
  if (display_name.size() > kMaxDisplayName) return Refuse("display name is longer than ", kMaxDisplayName);
  if (labels.size() > kMaxLabels) return Refuse("more than ", kMaxLabels, " labels");
  for (const auto& [key, value] : labels) {
    if (key.empty() || key.size() > kMaxLabelKey || value.size() > kMaxLabelValue || !IsUtf8(key) ||
        !IsUtf8(value)) {
      return Refuse("a label is empty, too long or not UTF-8");
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateChanges(const MapChanges& changes) {
  SEMMAP_RETURN_IF_ERROR(
      ValidateDescription(changes.display_name.value_or(""), changes.labels.value_or(Labels())));
  if (!changes.anchor.has_value() || !changes.anchor->has_value()) return absl::OkStatus();
  return ValidateAnchor(**changes.anchor);
}

absl::Status ValidateNewSession(const NewSession& session) {
  const auto printable = [](char c) { return absl::ascii_isgraph(static_cast<unsigned char>(c)); };
  if (session.name.empty() || session.name.size() > kMaxSessionName ||
      !std::all_of(session.name.begin(), session.name.end(), printable)) {
    return Refuse("session name must be 1 to ", kMaxSessionName, " printable ASCII characters");
  }
  if (session.vehicle_id.size() > kMaxVehicleId) return Refuse("vehicle id is longer than ", kMaxVehicleId);
  return ValidateRigValues(session.rig);
}

absl::Status ValidateAnchor(const GeoAnchor& anchor) {
  // Written so that not-a-number fails.
  if (!(std::abs(anchor.latitude_deg) <= 90)) return Refuse("anchor: latitude out of range");
  if (!(std::abs(anchor.longitude_deg) <= 180)) return Refuse("anchor: longitude out of range");
  if (!std::isfinite(anchor.altitude_m)) return Refuse("anchor: altitude is not finite");
  const double scale = anchor.enu_from_map.scale;
  if (!std::isfinite(scale) || !(scale > 0)) return Refuse("anchor: scale must be positive");
  if (!(anchor.rms_error_m >= 0) || !std::isfinite(anchor.rms_error_m))
    return Refuse("anchor: bad rms error");
  return IsStorable(anchor.enu_from_map.rigid) ? absl::OkStatus()
                                               : Refuse("anchor: enu_from_map is not finite");
}

absl::Status ValidateCounters(const SessionCounters& counters) {
  const bool ok = FitsSigned(counters.frames_received) && FitsSigned(counters.frames_tracked);
  return ok ? absl::OkStatus() : Refuse("session counters out of range");
}

absl::Status ValidateBox(const std::optional<Eigen::AlignedBox3d>& box) {
  if (!box.has_value()) return absl::OkStatus();
  if (!box->min().allFinite() || !box->max().allFinite()) return Refuse("box is not finite");
  return box->isEmpty() ? Refuse("box is empty: a minimum exceeds its maximum") : absl::OkStatus();
}

}  // namespace semmap::storage
