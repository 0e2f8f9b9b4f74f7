#pragma once

#include <span>
#include <vector>

#include "slam/geometry/se3.h"
#include "slam/optimize/observation.h"

namespace semmap {

struct PoseObservation {
  Eigen::Vector3d point_in_map;
  PixelObservation pixel;
};

struct PoseEstimate {
  SE3 camera_from_map;
  // Inverse of the information matrix at the optimum; tangent (translation, rotation) of a right
  // perturbation: map_from_camera = estimate * Exp(delta), delta in the camera frame.
  Matrix6d covariance = Matrix6d::Zero();
  int inliers = 0;
};

// Motion-only bundle adjustment: minimizes the Huber-robust reprojection error over one camera pose by
// Gauss-Newton/Levenberg steps on SE(3), in four rounds; after each, observations are sorted anew into
// inliers and outliers by chi^2 (ORB-SLAM, Mur-Artal et al., IEEE TRO 2015, section V and appendix). The
// fixed-size normal equations are solved here instead of by Ceres since building a problem for each frame
// would cost more than solving it. `outlier` is resized to observations.size(). Fewer than 4 inliers: pose
// unchanged, inliers as counted.
PoseEstimate OptimizePose(const ProjectionModel& model, const SE3& initial_camera_from_map,
                          std::span<const PoseObservation> observations, std::vector<char>* outlier);

}  // namespace semmap
