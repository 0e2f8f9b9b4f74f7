#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "slam/geometry/camera.h"

namespace semmap {

struct TwoViewReconstruction {
  // Translation has unit length.
  SE3 second_from_first;
  // For each match given: the point in the first camera's frame, where it is good.
  std::vector<std::optional<Eigen::Vector3d>> points_in_first;
  int good_points = 0;
  double median_parallax_rad = 0;
  bool from_homography = false;
};

struct TwoViewOptions {
  double sigma_px = 1.0;
  int iterations = 500;  // at most: fewer with few outliers
  int min_good_points = 50;
  double min_parallax_rad = 0.0175;  // one degree
  uint32_t seed = 0;
};

// Relative pose and structure from matches of undistorted pixels in two images: a homography and a
// fundamental matrix are estimated in parallel by RANSAC, the model is chosen by the ratio of their symmetric
// transfer scores, and the motion hypothesis (of the homography or the essential matrix) with clearly
// the most points in front of both cameras and enough parallax wins (Mur-Artal et al. 2015, section IV).
// nullopt when no hypothesis is clear. first[i] matches second[i].
std::optional<TwoViewReconstruction> ReconstructTwoViews(const CameraIntrinsics& camera,
                                                         const std::vector<Eigen::Vector2d>& first,
                                                         const std::vector<Eigen::Vector2d>& second,
                                                         const TwoViewOptions& options);

}  // namespace semmap
