#include <algorithm>
#include <cmath>
#include <numbers>

#include <spdlog/spdlog.h>

#include "absl/time/clock.h"
#include "server/error_reasons.h"
#include "server/frame_decoder.h"
#include "server/geo_frame.h"
#include "server/handlers/localization_handlers.h"
#include "server/handlers/map_handlers.h"
#include "server/pose_conversion.h"
#include "server/rig_conversion.h"
#include "server/session_conversion.h"
#include "slam/common/status_macros.h"
#include "slam/pipeline/frame_builder.h"

namespace semmap::server {
namespace {

constexpr size_t kMaxKeyFrames = 16;
constexpr double kMaxLatitude = 90;
constexpr double kMaxLongitude = 180;

absl::Status PriorInvalid(const std::string& field, const std::string& what) {
  return FieldInvalid("prior." + field, what);
}

absl::StatusOr<PlacePrior::Position> GeoPrior(const v1::GeoPosition& position, double radius_m,
                                              const storage::MapInfo& map) {
  const Eigen::Vector3d geographic(position.longitude_deg(), position.latitude_deg(), position.altitude_m());
  // Written so that not-a-number fails.
  const bool on_earth = std::abs(geographic.x()) <= kMaxLongitude &&
                        std::abs(geographic.y()) <= kMaxLatitude && std::isfinite(geographic.z());
  if (!on_earth) return PriorInvalid("geo_position", "is no place on Earth");
  SEMMAP_ASSIGN_OR_RETURN(const GeoFrame frame, GeoFrameOf(map));
  PlacePrior::Position prior = {frame.ToMap(geographic), radius_m / frame.metres_per_unit()};
  if (position.altitude_m() == 0) prior.up_in_map = frame.UpInMap();
  return prior;
}

absl::StatusOr<PlacePrior> PriorFromProto(const v1::PosePrior& proto, const storage::MapInfo& map) {
  PlacePrior prior;
  if (proto.has_geo_position() && proto.has_position_in_map())
    return PriorInvalid("geo_position", "is instead of position_in_map");
  const bool has_position = proto.has_geo_position() || proto.has_position_in_map();
  if (has_position && !(std::isfinite(proto.radius_m()) && proto.radius_m() > 0))
    return PriorInvalid("radius_m", "must be greater than zero");
  if (proto.has_geo_position()) {
    SEMMAP_ASSIGN_OR_RETURN(prior.position, GeoPrior(proto.geo_position(), proto.radius_m(), map));
  } else if (proto.has_position_in_map()) {
    prior.position = {FromProto(proto.position_in_map()), proto.radius_m()};
    if (!prior.position->in_map.allFinite()) return PriorInvalid("position_in_map", "is not finite");
  }
  if (proto.has_heading_in_map()) {
    const Eigen::Vector3d heading = FromProto(proto.heading_in_map());
    const double tolerance = proto.heading_tolerance_rad();
    if (!heading.allFinite() || heading.norm() < 1e-9)
      return PriorInvalid("heading_in_map", "is no direction");
    // Written so that not-a-number fails.
    if (!(tolerance > 0 && tolerance <= std::numbers::pi))
      return PriorInvalid("heading_tolerance_rad", "must be in (0, pi]");
    prior.heading = {heading.normalized(), tolerance};
  }
  return prior;
}

// Who asks waits for an answer anyway, which should not depend on how busy the network is: a picture gets its
// classes however long that takes.
SlamConfig ForPictures(SlamConfig config) {
  config.segmentation.max_wait_ms = 0;
  return config;
}

v1::GeoPosition ToGeoPosition(const storage::GeoAnchor& anchor, const Eigen::Vector3d& point_in_map) {
  const Eigen::Vector3d geographic = GeoFrame(anchor).ToGeographic(point_in_map);
  v1::GeoPosition position;
  position.set_longitude_deg(geographic.x());
  position.set_latitude_deg(geographic.y());
  position.set_altitude_m(geographic.z());
  return position;
}

void Describe(const MapFix& found, const MapSnapshot& map, const FrameFeatures& features,
              v1::RelocalizeResponse* response) {
  *response->mutable_map_from_camera() = ToProto(found.fix.camera_from_map.Inverse());
  *response->mutable_covariance() = ToProto(found.fix.covariance);
  for (const KeyFrameId id : KeyFramesSeeing(map, found, kMaxKeyFrames))
    response->add_keyframe_ids(id.value());
  if (const auto agreement = ClassAgreement(found, features)) response->set_class_agreement(*agreement);
}

}  // namespace

absl::StatusOr<RelocalizeTask> PrepareRelocalize(const ServiceContext& context,
                                                 const v1::RelocalizeRequest& request) {
  RelocalizeTask task;
  SEMMAP_ASSIGN_OR_RETURN(task.rig, RigFromProto(request.rig(), context.config.max_image_pixels));
  SEMMAP_RETURN_IF_ERROR(CheckImagesPresent(request.frame(), task.rig.sensor));
  SEMMAP_ASSIGN_OR_RETURN(task.map, FindMap(context, "map", request.map()));
  SEMMAP_ASSIGN_OR_RETURN(task.prior, PriorFromProto(request.prior(), task.map));
  if (task.map.keyframe_count == 0) return Error(v1::ERROR_REASON_MAP_EMPTY, "the map has no keyframes");
  return task;
}

absl::StatusOr<v1::RelocalizeResponse> Relocalize(const ServiceContext& context,
                                                  const v1::RelocalizeRequest& request,
                                                  const RelocalizeTask& task, const MapSnapshot& map) {
  const absl::Time start = absl::Now();
  CameraRig rig = task.rig;
  const SlamConfig slam = ForPictures(context.slam);
  const bool segments = context.segmentation != nullptr && slam.segmentation.mode != SegmentationMode::kOff;
  SEMMAP_ASSIGN_OR_RETURN(const FrameInput input, DecodeFrame(request.frame(), rig, segments));
  // Depth in metres says nothing where the map's unit is arbitrary: there, one eye looks.
  if (!map.scale_known()) rig.sensor = SensorType::kMono;
  FrameBuilder builder(slam, rig, context.segmentation);
  StageTimes times;
  const TrackedFrame frame = builder.Build(input, segments, &times);

  v1::RelocalizeResponse response;
  response.set_map_version(map.version());
  if (frame.features->size() < static_cast<size_t>(slam.relocalization.limits.min_inliers)) {
    response.set_result(v1::RELOCALIZE_RESULT_TOO_FEW_FEATURES);
  } else {
    const MapLocalizer localizer(slam.relocalization, static_cast<uint32_t>(slam.seed));
    const auto looked =
        localizer.Locate(map, MakeMappingCamera(slam, builder), {*frame.features, *frame.grid}, task.prior);
    if (absl::IsNotFound(looked.status())) return WithReason(looked.status(), v1::ERROR_REASON_MAP_NOT_FOUND);
    if (!looked.ok()) return FromStore(looked.status());
    const MapLocalization& located = *looked;
    spdlog::debug("relocalize map={} result={} candidates={} matches={} inliers={} expected={} rival={}",
                  task.map.name, static_cast<int>(located.failure), located.candidates, located.matches,
                  located.agreement.inliers, located.agreement.expected, located.rival_inliers);
    response.set_result(ToProto(located.failure));
    response.set_inliers(located.agreement.inliers);
    response.set_matches(located.matches);
    if (located.found) {
      Describe(*located.found, map, *frame.features, &response);
      const Eigen::Vector3d position = located.found->fix.camera_from_map.Inverse().translation();
      if (task.map.anchor) *response.mutable_geo_position() = ToGeoPosition(*task.map.anchor, position);
      response.set_map_version(located.found->view->version);
    }
  }
  response.set_processing_ms(absl::ToDoubleMilliseconds(absl::Now() - start));
  return response;
}

}  // namespace semmap::server
