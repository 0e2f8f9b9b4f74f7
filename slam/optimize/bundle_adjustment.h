#pragma once

#include <atomic>
#include <vector>

#include "slam/common/fwd.h"
#include "slam/geometry/se3.h"
#include "slam/optimize/observation.h"

namespace semmap {

struct BundleCamera {
  SE3 camera_from_map;
  bool fixed = false;
};

struct BundleObservation {
  int camera = 0;  // index into BundleProblem::cameras
  int point = 0;   // index into BundleProblem::points
  PixelObservation pixel;
  bool outlier = false;  // set by the solver: over the chi^2 bound, or behind the camera, at the end
};

// A window of the map, copied out so that the solver needs no lock and no knowledge of the map.
struct BundleProblem {
  ProjectionModel model;
  std::vector<BundleCamera> cameras;
  std::vector<Eigen::Vector3d> points;
  std::vector<BundleObservation> observations;
};

struct BundleOptions {
  int first_iterations = 5;    // robust, all observations
  int second_iterations = 10;  // without the outliers of the first round
  int threads = 1;
  // Optional: becoming true ends the solve after the current iteration.
  const std::atomic<bool>* stop = nullptr;
};

struct BundleSummary {
  double initial_cost = 0;
  double final_cost = 0;
  int iterations = 0;
  int outliers = 0;
  bool stopped = false;
};

// Bundle adjustment over the free cameras and all points (Ceres, sparse Schur complement, Huber loss,
// analytic Jacobians); updates cameras and points and marks outliers. At least one camera must be fixed (two,
// or stereo observations, for scale). Deterministic with threads = 1.
BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem* problem);

}  // namespace semmap
