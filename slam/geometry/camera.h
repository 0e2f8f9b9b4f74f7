#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "absl/status/status.h"
#include "slam/geometry/se3.h"

namespace semmap {

enum class DistortionModel {
  kNone,              // pinhole
  kRadialTangential,  // Brown: k1 k2 p1 p2 k3, as OpenCV orders them
  kEquidistant,       // Kannala-Brandt fisheye: k1 k2 k3 k4, as cv::fisheye
};

// One calibrated camera. Pixels: the centre of the top-left pixel is (0, 0). Camera frame: x right, y down,
// z forward.
struct CameraIntrinsics {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  DistortionModel distortion_model = DistortionModel::kNone;
  std::array<double, 5> distortion{};
};

enum class SensorType { kMono, kStereo, kRgbd };

// What a vehicle looks through. Stereo images are rectified, the right camera lying `baseline_m` along +x of
// the left one with the same intrinsics and no distortion; depth images are registered to the (left) image.
struct CameraRig {
  SensorType sensor = SensorType::kMono;
  CameraIntrinsics camera;
  // Stereo: the true baseline. RGB-D: the virtual baseline that turns depth into a disparity, so that both
  // sensors share one observation model (u, v, u_right); 0 lets ValidateRig's caller take the default. Mono:
  // ignored.
  double baseline_m = 0;
  // RGB-D: depth image units per metre (1000 for millimetres, 5000 for TUM).
  double depth_units_per_metre = 1000;
  double frames_per_second = 10;
  SE3 body_from_camera;
};

// Refuses what cannot be a camera: non-finite or non-positive values, principal point outside the image,
// absurd sizes, stereo with distortion, stereo without a baseline. The message names the field.
absl::Status ValidateRig(const CameraRig& rig);

// Pinhole projection of undistorted coordinates, with fx etc. of the intrinsics. point.z() must be positive.
inline Eigen::Vector2d ProjectPinhole(const CameraIntrinsics& camera,
                                      const Eigen::Vector3d& point_in_camera) {
  const double inverse_z = 1.0 / point_in_camera.z();
  return {camera.fx * point_in_camera.x() * inverse_z + camera.cx,
          camera.fy * point_in_camera.y() * inverse_z + camera.cy};
}

// The viewing ray with z = 1 of an undistorted pixel.
inline Eigen::Vector3d RayOfPixel(const CameraIntrinsics& camera, const Eigen::Vector2d& pixel) {
  return {(pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy, 1.0};
}

// Moves raw image coordinates to where an undistorted pinhole camera with the same fx, fy, cx, cy sees them.
// In place; a no-op for kNone.
void UndistortPixels(const CameraIntrinsics& camera, std::vector<Eigen::Vector2f>* pixels);

// The smallest axis-aligned box that holds the undistorted image, ending two image sides outside the image
// where a fisheye's border goes to infinity.
struct ImageBounds {
  float min_x = 0;
  float min_y = 0;
  float max_x = 0;
  float max_y = 0;

  bool Contains(float x, float y) const { return x >= min_x && x < max_x && y >= min_y && y < max_y; }
};
ImageBounds UndistortedBounds(const CameraIntrinsics& camera);

}  // namespace semmap
