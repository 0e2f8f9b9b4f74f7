#include "server/map_conversion.h"

#include "absl/strings/str_cat.h"
#include "server/error_reasons.h"
#include "server/names.h"
#include "server/pose_conversion.h"
#include "server/session_conversion.h"
#include "slam/semantics/taxonomy.h"

namespace semmap::server {
namespace {

v1::Box BoxToProto(const Eigen::AlignedBox3d& box) {
  v1::Box proto;
  *proto.mutable_min() = ToProto(Eigen::Vector3d(box.min()));
  *proto.mutable_max() = ToProto(Eigen::Vector3d(box.max()));
  return proto;
}

v1::GeoAnchor AnchorToProto(const storage::GeoAnchor& anchor) {
  v1::GeoAnchor proto;
  proto.mutable_origin()->set_latitude_deg(anchor.latitude_deg);
  proto.mutable_origin()->set_longitude_deg(anchor.longitude_deg);
  proto.mutable_origin()->set_altitude_m(anchor.altitude_m);
  proto.mutable_enu_from_map()->set_scale(anchor.enu_from_map.scale);
  *proto.mutable_enu_from_map()->mutable_pose() = ToProto(anchor.enu_from_map.rigid);
  const bool fitted = anchor.source == storage::GeoAnchor::Source::kFitted;
  proto.set_source(fitted ? v1::GeoAnchor::SOURCE_GNSS : v1::GeoAnchor::SOURCE_MANUAL);
  proto.set_rms_error_m(anchor.rms_error_m);
  return proto;
}

}  // namespace

std::string ClassName(unsigned semantic_class) {
  return semantic_class < kSemanticClasses.size() ? std::string(kSemanticClasses[semantic_class].name)
                                                  : "Unknown";
}

std::string EtagOf(const storage::MapInfo& map) {
  return absl::StrCat(map.id.value(), "-", map.version, "-", map.revision);
}

v1::Map ToProto(const storage::MapInfo& map) {
  v1::Map proto;
  proto.set_name(MapName(map.name));
  proto.set_display_name(map.display_name);
  proto.mutable_labels()->insert(map.labels.begin(), map.labels.end());
  proto.set_state(map.keyframe_count == 0 ? v1::MAP_STATE_EMPTY : v1::MAP_STATE_READY);
  proto.set_version(map.version);
  *proto.mutable_create_time() = ToTimestamp(map.created_at);
  if (map.updated_at.has_value()) *proto.mutable_update_time() = ToTimestamp(*map.updated_at);
  if (map.anchor.has_value()) *proto.mutable_anchor() = AnchorToProto(*map.anchor);
  proto.set_keyframe_count(static_cast<int64_t>(map.keyframe_count));
  proto.set_point_count(static_cast<int64_t>(map.point_count));
  proto.set_etag(EtagOf(map));
  return proto;
}

v1::MapSummary ToProto(const storage::MapSummary& summary) {
  v1::MapSummary proto;
  *proto.mutable_map() = ToProto(summary.map);
  if (!summary.point_extent.isEmpty()) *proto.mutable_point_extent() = BoxToProto(summary.point_extent);
  if (!summary.camera_extent.isEmpty()) *proto.mutable_keyframe_extent() = BoxToProto(summary.camera_extent);
  proto.set_trajectory_length_m(summary.trajectory_length);
  proto.set_frame_count(static_cast<int64_t>(summary.frame_count));
  for (const auto& count : summary.points_per_class) {
    v1::ClassCount* entry = proto.add_classes();
    entry->set_semantic_class(count.semantic_class);
    entry->set_display_name(ClassName(count.semantic_class));
    entry->set_points(static_cast<int64_t>(count.points));
  }
  proto.set_size_bytes(static_cast<int64_t>(summary.feature_bytes + summary.observation_bytes));
  proto.set_first_timestamp_ns(summary.first_keyframe_time);
  proto.set_last_timestamp_ns(summary.last_keyframe_time);
  proto.set_session_count(static_cast<int64_t>(summary.session_count));
  return proto;
}

absl::StatusOr<Eigen::AlignedBox3d> FromProto(const v1::Box& box) {
  const Eigen::AlignedBox3d result(FromProto(box.min()), FromProto(box.max()));
  const bool finite = result.min().allFinite() && result.max().allFinite();
  if (finite && !result.isEmpty()) return result;
  return Error(v1::ERROR_REASON_AREA_INVALID, "the box is inverted or not finite", {{"field", "area.box"}});
}

absl::StatusOr<storage::TimeRange> FromProto(const v1::TimeRange& range) {
  storage::TimeRange result;
  if (range.has_start_ns()) result.begin = range.start_ns();
  if (range.has_end_ns()) result.end = range.end_ns();
  if (result.begin <= result.end) return result;
  return Error(v1::ERROR_REASON_FIELD_INVALID, "the time range ends before it begins", {{"field", "time"}});
}

}  // namespace semmap::server
