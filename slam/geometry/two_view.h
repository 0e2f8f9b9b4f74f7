#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "slam/geometry/camera.h"

namespace semmap {

struct TwoViewReconstruction {
  // Translation has unit length.
  SE3 second_from_first;
  // For each match given: the point in the first camera's frame, where it is good: in front of both cameras,
  // seen where it was matched, and with a parallax of at least four standard deviations of a ray.
  std::vector<std::optional<Eigen::Vector3d>> points_in_first;
  int good_points = 0;
  double median_parallax_rad = 0;
  bool from_homography = false;
};

struct TwoViewOptions {
  double sigma_px = 1.0;
  int iterations = 500;  // at most: fewer with few outliers
  int min_good_points = 50;
  // Of the good points' median. One degree; on KITTI half of it still gave no wrong motion.
  double min_parallax_rad = 0.0175;
  uint32_t seed = 0;
};

// Relative pose and structure from matches of undistorted pixels in two images: a homography and a calibrated
// fundamental matrix are estimated by RANSAC, the model is chosen by the ratio of their symmetric transfer
// scores (Mur-Artal et al. 2015, section IV), and of the motions that it allows the one that explains clearly
// the most matches wins, if enough of its points have enough parallax. nullopt when no motion is clear.
// first[i] matches second[i]. Deterministic for a given seed.
std::optional<TwoViewReconstruction> ReconstructTwoViews(const CameraIntrinsics& camera,
                                                         const std::vector<Eigen::Vector2d>& first,
                                                         const std::vector<Eigen::Vector2d>& second,
                                                         const TwoViewOptions& options);

}  // namespace semmap
