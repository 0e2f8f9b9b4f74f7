#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "slam/geometry/camera.h"

namespace semmap {

struct PnpOptions {
  // Reprojection error up to which a match is an inlier.
  double max_error_px = 4.0;
  // At most; fewer once a sample free of outliers was drawn with this confidence.
  int max_iterations = 500;
  double confidence = 0.999;
  int min_inliers = 10;
  uint32_t seed = 0;
};

struct PnpResult {
  SE3 camera_from_map;
  std::vector<char> inlier;  // one for each match, 1 or 0
  int inliers = 0;
};

// Absolute pose of a calibrated camera from matches of points in the map with undistorted pixels, most of
// which may be wrong: RANSAC over three matches (AP3P, Ke and Roumeliotis 2017), models compared by the
// truncated squared error (MSAC, Torr and Zisserman 2000), the best refined on its inliers by
// Levenberg-Marquardt. nullopt for spans of different sizes, fewer than 4 matches, and fewer than min_inliers
// inliers. Deterministic for a given seed.
std::optional<PnpResult> EstimatePose(const CameraIntrinsics& camera,
                                      std::span<const Eigen::Vector3d> points_in_map,
                                      std::span<const Eigen::Vector2d> undistorted_pixels,
                                      const PnpOptions& options);

}  // namespace semmap
