#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slam/geometry/se3.h"
#include "slam/optimize/observation.h"
#include "slam/optimize/pose_optimizer.h"

namespace semmap {

// Gauss-Newton's view of the cost sum rho(r^T r / sigma^2) / 2 around one pose; the tangent (translation,
// rotation) is a left perturbation: camera_from_map = Exp(delta) * linearization point.
struct PoseNormalEquations {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double cost = 0;
};

// The observations of one pose as a structure of arrays, eight side by side, so that one instruction works on
// several. One allocation per object; not thread-safe.
class PoseObservationBatches {
 public:
  // Observations that are not finite are never used.
  PoseObservationBatches(const ProjectionModel& model, std::span<const PoseObservation> observations);

  int usable() const { return usable_; }

  // Sums over the active observations with Huber weights, whose bound is the one between inlier and outlier.
  // Points behind the camera give no gradient but a constant cost, so that no step gains by turning away.
  void Linearize(const SE3& camera_from_map, PoseNormalEquations* equations) const;

  // Makes active exactly what is in front of the camera and under its chi^2 bound; returns how many. *changed
  // (optional) tells whether any differs from before. At first all usable ones are active.
  int ClassifyInliers(const SE3& camera_from_map, bool* changed);

  // One flag for each observation given, 1 where it is not active.
  void CopyOutliers(std::vector<char>* outlier) const;

 private:
  static constexpr int kLanes = 8;
  using Lane = Eigen::Array<double, kLanes, 1>;

  struct Batch {
    Lane x = Lane::Zero();  // point in the map
    Lane y = Lane::Zero();
    Lane z = Lane::Zero();
    Lane u = Lane::Zero();
    Lane v = Lane::Zero();
    Lane u_right = Lane::Zero();
    Lane inverse_sigma2 = Lane::Zero();
    Lane chi2_bound = Lane::Constant(kChi2Mono);
    Lane stereo = Lane::Zero();  // 1 where u_right counts
    Lane usable = Lane::Zero();  // 0 for padding
    Lane active = Lane::Zero();
  };

  struct Pose;
  struct Projection;
  class Sums;

  void Fill(const PoseObservation& observation, int lane, Batch* batch);
  static Pose PoseOf(const SE3& camera_from_map);
  Projection Project(const Pose& pose, const Batch& batch) const;
  void AddBatch(const Batch& batch, const Projection& projection, Sums* sums) const;

  ProjectionModel model_;
  std::vector<Batch> batches_;
  size_t size_ = 0;
  int usable_ = 0;
  bool any_stereo_ = false;
};

}  // namespace semmap
