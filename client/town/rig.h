#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "slam/common/config_reader.h"
#include "slam/geometry/camera.h"
#include "slam/geometry/se3.h"

namespace semmap::town {

// What a simulated vehicle carries; read from a YAML file, one key a member.
struct RigConfig {
  int width = 800;  // pixels, 64 to 4096
  int height = 600;
  double fov_degrees = 90;        // horizontal, 20 to 150
  double frames_per_second = 20;  // 10 to 100; the town moves by as much from frame to frame
  double baseline_m = 0.5;        // of the right camera, 0.02 to 3
  double camera_forward_m = 0.9;  // of the left camera, in the vehicle's frame
  double camera_left_m = 0.0;
  double camera_height_m = 1.5;
  double camera_pitch_degrees = 0;  // downwards
  double vignetting = 0.25;
  double speed_noise = 0.005;       // deviation of the wheel speed, share
  double speed_scale_error = 0.01;  // deviation of its constant factor between vehicles
  double gnss_noise_m = 0.6;        // deviation of each fix, horizontal
  double gnss_drift_m = 1.5;        // deviation of the slowly wandering part
  double gnss_hertz = 5;
  double origin_latitude = 59.9396;  // of the town's origin, degrees
  double origin_longitude = 30.3141;
  double origin_altitude = 12.0;

  void Read(ConfigReader& reader);
  static absl::StatusOr<RigConfig> FromFile(const std::string& path);

  CameraIntrinsics Intrinsics() const;
  // x forwards, y left, z up, origin on the ground below the middle of the vehicle.
  SE3 VehicleFromCamera() const;
};

}  // namespace semmap::town
