#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "slam/geometry/camera.h"

namespace semmap::client {

// What a camera's sensor.yaml in a EuRoC data set says.
struct EurocCamera {
  CameraIntrinsics intrinsics;
  double frames_per_second = 20;
  SE3 body_from_camera;  // its T_BS
};

// Pinhole with radial-tangential, equidistant or no distortion; INVALID_ARGUMENT naming file and key
// otherwise.
absl::StatusOr<EurocCamera> ReadEurocCamera(const std::string& path);

}  // namespace semmap::client
