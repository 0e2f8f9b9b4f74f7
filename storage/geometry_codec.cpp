#include "storage/geometry_codec.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap::storage {
namespace {

constexpr uint8_t kRigFormat = 1;
// A stored rotation was a unit quaternion; a flipped bit that matters shows as another length.
constexpr double kUnitTolerance = 1e-6;

std::array<double, 7> Coefficients(const SE3& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

absl::StatusOr<SE3> PoseOf(const std::array<double, 7>& c) {
  const Eigen::Quaterniond rotation(c[6], c[3], c[4], c[5]);
  const SE3 pose = SE3::FromUnitQuaternion(rotation, {c[0], c[1], c[2]});
  if (!pose.IsFinite()) return absl::DataLossError("stored pose is not finite");
  if (std::abs(rotation.norm() - 1.0) > kUnitTolerance) {
    return absl::DataLossError("stored rotation is no unit quaternion");
  }
  return pose;
}

void PutCamera(const CameraIntrinsics& camera, ByteWriter* out) {
  out->Put<int32_t>(camera.width);
  out->Put<int32_t>(camera.height);
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) out->Put(value);
  out->Put(static_cast<uint8_t>(camera.distortion_model));
  out->PutArray(std::span<const double>(camera.distortion));
}

bool GetCamera(ByteReader* in, CameraIntrinsics* camera) {
  camera->width = in->Get<int32_t>();
  camera->height = in->Get<int32_t>();
  for (double* value : {&camera->fx, &camera->fy, &camera->cx, &camera->cy}) *value = in->Get<double>();
  const auto model = in->Get<uint8_t>();
  camera->distortion_model = static_cast<DistortionModel>(model);
  in->GetArray(std::span<double>(camera->distortion));
  return in->ok() && model <= static_cast<uint8_t>(DistortionModel::kEquidistant);
}

}  // namespace

std::array<uint8_t, kPackedPoseSize> EncodePose(const SE3& pose) {
  return std::bit_cast<std::array<uint8_t, kPackedPoseSize>>(Coefficients(pose));
}

absl::StatusOr<SE3> DecodePose(BlobView bytes) {
  if (bytes.size() != kPackedPoseSize) {
    return absl::DataLossError(absl::StrCat("stored pose has ", bytes.size(), " bytes"));
  }
  std::array<double, 7> coefficients{};
  std::memcpy(coefficients.data(), bytes.data(), kPackedPoseSize);
  return PoseOf(coefficients);
}

Blob EncodeSim3(const Sim3& transform) {
  ByteWriter out;
  out.Put(transform.scale);
  out.PutArray(std::span<const double>(Coefficients(transform.rigid)));
  return out.Take();
}

absl::StatusOr<Sim3> DecodeSim3(BlobView bytes) {
  ByteReader in(bytes);
  Sim3 transform;
  transform.scale = in.Get<double>();
  std::array<double, 7> coefficients{};
  in.GetArray(std::span<double>(coefficients));
  if (!in.AtEnd() || !std::isfinite(transform.scale) || transform.scale <= 0) {
    return absl::DataLossError("stored similarity cannot be decoded");
  }
  SEMMAP_ASSIGN_OR_RETURN(transform.rigid, PoseOf(coefficients));
  return transform;
}

Blob EncodeRig(const CameraRig& rig) {
  ByteWriter out;
  out.Put(kRigFormat);
  out.Put(static_cast<uint8_t>(rig.sensor));
  PutCamera(rig.camera, &out);
  for (const double value : {rig.baseline_m, rig.depth_units_per_metre, rig.frames_per_second}) {
    out.Put(value);
  }
  out.PutArray(std::span<const double>(Coefficients(rig.body_from_camera)));
  return out.Take();
}

absl::StatusOr<CameraRig> DecodeRig(BlobView bytes) {
  ByteReader in(bytes);
  CameraRig rig;
  const auto format = in.Get<uint8_t>();
  const auto sensor = in.Get<uint8_t>();
  rig.sensor = static_cast<SensorType>(sensor);
  const bool camera_ok = GetCamera(&in, &rig.camera);
  for (double* value : {&rig.baseline_m, &rig.depth_units_per_metre, &rig.frames_per_second}) {
    *value = in.Get<double>();
  }
  std::array<double, 7> coefficients{};
  in.GetArray(std::span<double>(coefficients));
  const bool sensor_ok = sensor <= static_cast<uint8_t>(SensorType::kRgbd);
  if (!in.AtEnd() || format != kRigFormat || !sensor_ok || !camera_ok) {
    return absl::DataLossError("stored camera rig cannot be decoded");
  }
  SEMMAP_ASSIGN_OR_RETURN(rig.body_from_camera, PoseOf(coefficients));
  return rig;
}

}  // namespace semmap::storage
