#include "server/rig_conversion.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "server/error_reasons.h"
#include "server/pose_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr double kDefaultDepthUnits = 1000;
constexpr double kDefaultFramesPerSecond = 10;

absl::Status RigInvalid(const std::string& field, const std::string& problem) {
  return Error(v1::ERROR_REASON_RIG_INVALID, absl::StrCat("rig.", field, " ", problem), {{"field", field}});
}

absl::StatusOr<SensorType> SensorFromProto(v1::SensorType sensor) {
  switch (sensor) {
    case v1::SENSOR_TYPE_MONO:
      return SensorType::kMono;
    case v1::SENSOR_TYPE_STEREO:
      return SensorType::kStereo;
    case v1::SENSOR_TYPE_RGBD:
      return SensorType::kRgbd;
    default:
      return RigInvalid("sensor", "must be MONO, STEREO or RGBD");
  }
}

// Number of coefficients, from and to, that a model takes.
struct ModelInfo {
  DistortionModel model;
  int min_coefficients;
  int max_coefficients;
};

absl::StatusOr<ModelInfo> ModelFromProto(v1::DistortionModel model) {
  switch (model) {
    case v1::DISTORTION_MODEL_NONE:
      return ModelInfo{DistortionModel::kNone, 0, 0};
    case v1::DISTORTION_MODEL_RADIAL_TANGENTIAL:
      return ModelInfo{DistortionModel::kRadialTangential, 4, 5};
    case v1::DISTORTION_MODEL_EQUIDISTANT:
      return ModelInfo{DistortionModel::kEquidistant, 4, 4};
    default:
      return RigInvalid("camera.distortion_model", "must be NONE, RADIAL_TANGENTIAL or EQUIDISTANT");
  }
}

absl::StatusOr<CameraIntrinsics> CameraFromProto(const v1::CameraIntrinsics& proto) {
  SEMMAP_ASSIGN_OR_RETURN(const ModelInfo info, ModelFromProto(proto.distortion_model()));
  const int count = proto.distortion_size();
  if (count < info.min_coefficients || count > info.max_coefficients) {
    return RigInvalid("camera.distortion",
                      absl::StrCat("has ", count, " values, must have ", info.min_coefficients, " to ",
                                   info.max_coefficients));
  }
  CameraIntrinsics camera;
  camera.width = proto.width();
  camera.height = proto.height();
  camera.fx = proto.fx();
  camera.fy = proto.fy();
  camera.cx = proto.cx();
  camera.cy = proto.cy();
  camera.distortion_model = info.model;
  std::copy(proto.distortion().begin(), proto.distortion().end(), camera.distortion.begin());
  return camera;
}

absl::StatusOr<SE3> BodyFromCamera(const v1::CameraRig& proto) {
  if (!proto.has_body_from_camera()) return SE3();
  auto pose = FromProto(proto.body_from_camera());
  if (pose.ok()) return pose;
  return RigInvalid("body_from_camera", std::string(pose.status().message()));
}

v1::SensorType ToProto(SensorType sensor) {
  switch (sensor) {
    case SensorType::kStereo:
      return v1::SENSOR_TYPE_STEREO;
    case SensorType::kRgbd:
      return v1::SENSOR_TYPE_RGBD;
    default:
      return v1::SENSOR_TYPE_MONO;
  }
}

void CopyDistortion(const CameraIntrinsics& camera, v1::CameraIntrinsics* proto) {
  proto->set_distortion_model(v1::DISTORTION_MODEL_NONE);
  if (camera.distortion_model == DistortionModel::kNone) return;
  const bool brown = camera.distortion_model == DistortionModel::kRadialTangential;
  proto->set_distortion_model(brown ? v1::DISTORTION_MODEL_RADIAL_TANGENTIAL
                                    : v1::DISTORTION_MODEL_EQUIDISTANT);
  const size_t count = brown ? 5 : 4;
  for (size_t i = 0; i < count; ++i) proto->add_distortion(camera.distortion[i]);
}

}  // namespace

absl::StatusOr<CameraRig> RigFromProto(const v1::CameraRig& proto, int64_t max_pixels) {
  CameraRig rig;
  SEMMAP_ASSIGN_OR_RETURN(rig.sensor, SensorFromProto(proto.sensor()));
  SEMMAP_ASSIGN_OR_RETURN(rig.camera, CameraFromProto(proto.camera()));
  SEMMAP_ASSIGN_OR_RETURN(rig.body_from_camera, BodyFromCamera(proto));
  // What a sensor ignores is not kept either: it may be anything, even not-a-number.
  rig.baseline_m = rig.sensor == SensorType::kMono ? 0 : proto.baseline_m();
  const bool own_units = rig.sensor == SensorType::kRgbd && proto.depth_units_per_metre() != 0;
  rig.depth_units_per_metre = own_units ? proto.depth_units_per_metre() : kDefaultDepthUnits;
  rig.frames_per_second =
      proto.frames_per_second() == 0 ? kDefaultFramesPerSecond : proto.frames_per_second();
  if (const absl::Status status = ValidateRig(rig); !status.ok()) {
    return WithReason(status, v1::ERROR_REASON_RIG_INVALID);
  }
  if (static_cast<int64_t>(rig.camera.width) * rig.camera.height > max_pixels) {
    return Error(v1::ERROR_REASON_IMAGE_TOO_LARGE,
                 absl::StrCat("rig.camera has more than the ", max_pixels, " pixels that this server allows"),
                 {{"field", "rig.camera"}});
  }
  return rig;
}

v1::CameraRig ToProto(const CameraRig& rig) {
  v1::CameraRig proto;
  proto.set_sensor(ToProto(rig.sensor));
  v1::CameraIntrinsics* camera = proto.mutable_camera();
  camera->set_width(rig.camera.width);
  camera->set_height(rig.camera.height);
  camera->set_fx(rig.camera.fx);
  camera->set_fy(rig.camera.fy);
  camera->set_cx(rig.camera.cx);
  camera->set_cy(rig.camera.cy);
  CopyDistortion(rig.camera, camera);
  proto.set_baseline_m(rig.baseline_m);
  proto.set_depth_units_per_metre(rig.depth_units_per_metre);
  proto.set_frames_per_second(rig.frames_per_second);
  *proto.mutable_body_from_camera() = ToProto(rig.body_from_camera);
  return proto;
}

}  // namespace semmap::server
