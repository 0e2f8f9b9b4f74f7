#include "client/town/rig.h"

#include <cmath>
#include <numbers>

#include "slam/common/status_macros.h"

namespace semmap::town {

void RigConfig::Read(ConfigReader& reader) {
  reader.Number("width", &width, 64, 4096);
  reader.Number("height", &height, 64, 4096);
  reader.Number("fov_degrees", &fov_degrees, 20, 150);
  reader.Number("frames_per_second", &frames_per_second, 10, 100);
  reader.Number("baseline_m", &baseline_m, 0.02, 3);
  reader.Number("camera_forward_m", &camera_forward_m, -5, 5);
  reader.Number("camera_left_m", &camera_left_m, -2, 2);
  reader.Number("camera_height_m", &camera_height_m, 0.3, 4);
  reader.Number("camera_pitch_degrees", &camera_pitch_degrees, -45, 45);
  reader.Number("vignetting", &vignetting, 0, 1);
  reader.Number("speed_noise", &speed_noise, 0, 1);
  reader.Number("speed_scale_error", &speed_scale_error, 0, 0.5);
  reader.Number("gnss_noise_m", &gnss_noise_m, 0, 100);
  reader.Number("gnss_drift_m", &gnss_drift_m, 0, 100);
  reader.Number("gnss_hertz", &gnss_hertz, 0.1, 100);
  reader.Number("origin_latitude", &origin_latitude, -85, 85);
  reader.Number("origin_longitude", &origin_longitude, -180, 180);
  reader.Number("origin_altitude", &origin_altitude, -500, 9000);
}

absl::StatusOr<RigConfig> RigConfig::FromFile(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(ConfigReader reader, ConfigReader::FromFile(path));
  RigConfig config;
  config.Read(reader);
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return config;
}

CameraIntrinsics RigConfig::Intrinsics() const {
  CameraIntrinsics camera;
  camera.width = width;
  camera.height = height;
  camera.fx = width / 2.0 / std::tan(fov_degrees / 2 * std::numbers::pi / 180);
  camera.fy = camera.fx;
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;
  return camera;
}

SE3 RigConfig::VehicleFromCamera() const {
  Eigen::Matrix3d looking_ahead;  // columns: the camera's x, y and z in the vehicle's frame
  looking_ahead << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::AngleAxisd pitch(camera_pitch_degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitY());
  return {Eigen::Matrix3d(pitch.toRotationMatrix() * looking_ahead),
          Eigen::Vector3d(camera_forward_m, camera_left_m, camera_height_m)};
}

}  // namespace semmap::town
