#include <algorithm>
#include <cmath>
#include <numbers>

#include <spdlog/spdlog.h>

#include "absl/time/clock.h"
#include "server/error_reasons.h"
#include "server/frame_decoder.h"
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

absl::Status PriorInvalid(const std::string& field, const std::string& what) {
  return Error(v1::ERROR_REASON_FIELD_INVALID, "prior." + field + " " + what, {{"field", "prior." + field}});
}

absl::StatusOr<PlacePrior> PriorFromProto(const v1::PosePrior& proto) {
  PlacePrior prior;
  if (proto.has_geo_position()) return NotImplemented("prior.geo_position");
  if (proto.has_position_in_map()) {
    prior.position = {FromProto(proto.position_in_map()), proto.radius_m()};
    if (!prior.position->in_map.allFinite()) return PriorInvalid("position_in_map", "is not finite");
    if (!std::isfinite(proto.radius_m()) || proto.radius_m() <= 0)
      return PriorInvalid("radius_m", "must be greater than zero");
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
  SEMMAP_ASSIGN_OR_RETURN(task.prior, PriorFromProto(request.prior()));
  SEMMAP_ASSIGN_OR_RETURN(task.map, FindMap(context, "map", request.map()));
  if (task.map.keyframe_count == 0) return Error(v1::ERROR_REASON_MAP_EMPTY, "the map has no keyframes");
  return task;
}

absl::StatusOr<v1::RelocalizeResponse> Relocalize(const ServiceContext& context,
                                                  const v1::RelocalizeRequest& request,
                                                  const RelocalizeTask& task, const MapSnapshot& map) {
  const absl::Time start = absl::Now();
  CameraRig rig = task.rig;
  SEMMAP_ASSIGN_OR_RETURN(const FrameInput input, DecodeFrame(request.frame(), rig, false));
  // Depth in metres says nothing where the map's unit is arbitrary: there, one eye looks.
  if (!map.scale_known()) rig.sensor = SensorType::kMono;
  // Classes come with the frame or not at all: the network is for those who drive.
  FrameBuilder builder(context.slam, rig, nullptr);
  StageTimes times;
  const TrackedFrame frame = builder.Build(input, false, &times);

  v1::RelocalizeResponse response;
  response.set_map_version(map.version());
  if (frame.features->size() < static_cast<size_t>(context.slam.relocalization.min_inliers)) {
    response.set_result(v1::RELOCALIZE_RESULT_TOO_FEW_FEATURES);
  } else {
    const MapLocalizer localizer(context.slam.relocalization, static_cast<uint32_t>(context.slam.seed));
    const auto looked = localizer.Locate(map, MakeMappingCamera(context.slam, builder),
                                         {*frame.features, *frame.grid}, task.prior);
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
      response.set_map_version(located.found->view->version);
    }
  }
  response.set_processing_ms(absl::ToDoubleMilliseconds(absl::Now() - start));
  return response;
}

}  // namespace semmap::server
