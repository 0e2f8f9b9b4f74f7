#include "client/cli/rig_conversion.h"

namespace semmap::client {
namespace {

v1::SensorType ToProto(SensorType sensor) {
  switch (sensor) {
    case SensorType::kMono:
      return v1::SENSOR_TYPE_MONO;
    case SensorType::kStereo:
      return v1::SENSOR_TYPE_STEREO;
    case SensorType::kRgbd:
      return v1::SENSOR_TYPE_RGBD;
  }
  return v1::SENSOR_TYPE_UNSPECIFIED;
}

void SetDistortion(const CameraIntrinsics& camera, v1::CameraIntrinsics* message) {
  size_t count = 0;
  switch (camera.distortion_model) {
    case DistortionModel::kNone:
      message->set_distortion_model(v1::DISTORTION_MODEL_NONE);
      break;
    case DistortionModel::kRadialTangential:
      message->set_distortion_model(v1::DISTORTION_MODEL_RADIAL_TANGENTIAL);
      count = 5;
      break;
    case DistortionModel::kEquidistant:
      message->set_distortion_model(v1::DISTORTION_MODEL_EQUIDISTANT);
      count = 4;
      break;
  }
  for (size_t i = 0; i < count; ++i) message->add_distortion(camera.distortion[i]);
}

}  // namespace

v1::Pose ToProto(const SE3& pose) {
  v1::Pose message;
  message.mutable_translation()->set_x(pose.translation().x());
  message.mutable_translation()->set_y(pose.translation().y());
  message.mutable_translation()->set_z(pose.translation().z());
  message.mutable_rotation()->set_x(pose.rotation().x());
  message.mutable_rotation()->set_y(pose.rotation().y());
  message.mutable_rotation()->set_z(pose.rotation().z());
  message.mutable_rotation()->set_w(pose.rotation().w());
  return message;
}

v1::CameraRig ToProto(const CameraRig& rig) {
  v1::CameraRig message;
  message.set_sensor(ToProto(rig.sensor));
  v1::CameraIntrinsics* camera = message.mutable_camera();
  camera->set_width(rig.camera.width);
  camera->set_height(rig.camera.height);
  camera->set_fx(rig.camera.fx);
  camera->set_fy(rig.camera.fy);
  camera->set_cx(rig.camera.cx);
  camera->set_cy(rig.camera.cy);
  SetDistortion(rig.camera, camera);
  if (rig.sensor != SensorType::kMono) message.set_baseline_m(rig.baseline_m);
  if (rig.sensor == SensorType::kRgbd) message.set_depth_units_per_metre(rig.depth_units_per_metre);
  message.set_frames_per_second(rig.frames_per_second);
  *message.mutable_body_from_camera() = ToProto(rig.body_from_camera);
  return message;
}

SE3 FromProto(const v1::Pose& pose) {
  const v1::Quaternion& q = pose.rotation();
  const v1::Vector3& t = pose.translation();
  const Eigen::Quaterniond rotation =
      pose.has_rotation() ? Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()) : Eigen::Quaterniond::Identity();
  return {rotation, Eigen::Vector3d(t.x(), t.y(), t.z())};
}

}  // namespace semmap::client
