#include "slam/optimize/pose_optimizer.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "slam/optimize/pose_normal_equations.h"

namespace semmap {
namespace {

constexpr int kRounds = 4;
constexpr int kIterationsPerRound = 10;
constexpr int kMinInliers = 4;

// Levenberg-Marquardt damping relative to the diagonal. It starts near Gauss-Newton: the motion model is
// close.
constexpr double kInitialDamping = 1e-6;
constexpr double kMinDamping = 1e-9;
constexpr double kMaxDamping = 1e4;
constexpr double kDampingDown = 0.1;
constexpr double kDampingUp = 20;
// Added to the diagonal so that directions without information stay where they are.
constexpr double kDiagonalFloor = 1e-9;
// A step that gains less than this fraction of the cost is far below the noise.
constexpr double kMinRelativeGain = 1e-5;

Vector6d DampedStep(const PoseNormalEquations& equations, double damping) {
  Matrix6d information = equations.information;
  information.diagonal() *= 1.0 + damping;
  information.diagonal().array() += kDiagonalFloor;
  return information.ldlt().solve(-equations.gradient);
}

// Minimizes over the active observations, from *camera_from_map on. Leaves in *equations what holds at the
// result.
void Minimize(const PoseObservationBatches& batches, SE3* camera_from_map, PoseNormalEquations* equations) {
  double damping = kInitialDamping;
  batches.Linearize(*camera_from_map, equations);
  for (int iteration = 0; iteration < kIterationsPerRound && damping < kMaxDamping; ++iteration) {
    const Vector6d step = DampedStep(*equations, damping);
    if (!step.allFinite()) return;
    const SE3 candidate = SE3::Exp(step) * *camera_from_map;
    PoseNormalEquations at_candidate;
    batches.Linearize(candidate, &at_candidate);
    const double gain = equations->cost - at_candidate.cost;
    if (gain < 0) {
      if (-gain <= kMinRelativeGain * equations->cost) return;  // at the bottom, to rounding
      damping *= kDampingUp;
      continue;
    }
    const bool converged = gain <= kMinRelativeGain * equations->cost;
    *camera_from_map = candidate;
    *equations = at_candidate;
    if (converged) return;
    damping = std::max(kMinDamping, damping * kDampingDown);
  }
}

Matrix6d InverseOf(const Matrix6d& information) {
  Matrix6d regular = information;
  regular.diagonal().array() += kDiagonalFloor;
  return regular.ldlt().solve(Matrix6d::Identity());
}

}  // namespace

PoseEstimate OptimizePose(const ProjectionModel& model, const SE3& initial_camera_from_map,
                          std::span<const PoseObservation> observations, std::vector<char>* outlier) {
  PoseObservationBatches batches(model, observations);
  SE3 camera_from_map = initial_camera_from_map;
  PoseNormalEquations equations;
  int inliers = batches.usable();
  for (int round = 0; round < kRounds && inliers >= kMinInliers; ++round) {
    Minimize(batches, &camera_from_map, &equations);
    bool changed = false;
    inliers = batches.ClassifyInliers(camera_from_map, &changed);
    if (!changed) break;  // the next round would start and end here
  }
  PoseEstimate estimate{.camera_from_map = initial_camera_from_map, .inliers = inliers};
  if (inliers < kMinInliers || !camera_from_map.IsFinite()) {
    estimate.inliers = batches.ClassifyInliers(initial_camera_from_map, nullptr);
  } else {
    batches.Linearize(camera_from_map, &equations);
    estimate.camera_from_map = camera_from_map;
    // A left perturbation of camera_from_map is a right one of map_from_camera with the sign turned, which a
    // covariance does not see.
    estimate.covariance = InverseOf(equations.information);
  }
  batches.CopyOutliers(outlier);
  return estimate;
}

}  // namespace semmap
