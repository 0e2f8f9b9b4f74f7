#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slam/geometry/camera.h"

namespace semmap::testing {

// A long room with noisy walls, drawn by casting a ray for each pixel: small, exact, and the same everywhere.
// Serves tests of the pipeline where no recorded sequence is at hand. Map frame: x right, y down, z along the
// room.
class TexturedRoom {
 public:
  explicit TexturedRoom(uint32_t seed) : seed_(seed) {}

  // What a pinhole camera sees: CV_8UC1; `depth` (optional) becomes CV_32FC1, metres along the camera's z.
  cv::Mat Render(const CameraIntrinsics& camera, const SE3& map_from_camera, cv::Mat* depth = nullptr) const;

 private:
  double Texture(int wall, double u, double v) const;
  double Noise(int wall, double u, double v) const;

  uint32_t seed_;
};

// A camera of 480 x 320 pixels.
CameraIntrinsics SmallCamera();
// A rig around SmallCamera; baseline 0.3 m for stereo.
CameraRig SmallRig(SensorType sensor);
// `count` camera poses of a gentle S-curve along the room, `step` metres apart.
std::vector<SE3> GentleDrive(int count, double step);
// On a small circle in the middle of where GentleDrive begins, looking so many degrees to the right of where
// that looks; 180: at the wall behind it.
SE3 LookAround(double degrees);

}  // namespace semmap::testing
