#include "slam/optimize/pose_normal_equations.h"

#include <array>
#include <cmath>

namespace semmap {
namespace {

bool IsUsable(const PoseObservation& observation) {
  const PixelObservation& pixel = observation.pixel;
  return observation.point_in_map.allFinite() && std::isfinite(pixel.u) && std::isfinite(pixel.v) &&
         std::isfinite(pixel.u_right) && std::isfinite(pixel.inverse_sigma2) && pixel.inverse_sigma2 > 0;
}

}  // namespace

struct PoseObservationBatches::Pose {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

// Normalized coordinates (x/z, y/z), inverse depth and residuals of a batch.
struct PoseObservationBatches::Projection {
  Lane x;
  Lane y;
  Lane inverse_z;
  Lane error_u;
  Lane error_v;
  Lane error_right;
  Lane chi2;
  Eigen::Array<bool, kLanes, 1> in_front;
};

// The lower triangle of the information matrix, the gradient and the cost, summed lane by lane.
class PoseObservationBatches::Sums {
 public:
  Sums() {
    information_.fill(Lane::Zero());
    gradient_.fill(Lane::Zero());
  }

  // One residual for each lane: its Jacobian row, weight and value.
  void AddRow(const std::array<Lane, 6>& row, const Lane& weight, const Lane& error) {
    int index = 0;
    for (int i = 0; i < 6; ++i) {
      const Lane weighted = weight * row[i];
      gradient_[i] += weighted * error;
      for (int j = 0; j <= i; ++j) information_[index++] += weighted * row[j];
    }
  }

  void AddCost(const Lane& cost) { cost_ += cost; }

  PoseNormalEquations Total() const {
    PoseNormalEquations equations;
    int index = 0;
    for (int i = 0; i < 6; ++i) {
      equations.gradient(i) = gradient_[i].sum();
      for (int j = 0; j <= i; ++j) {
        equations.information(i, j) = equations.information(j, i) = information_[index++].sum();
      }
    }
    equations.cost = 0.5 * cost_.sum();
    return equations;
  }

 private:
  std::array<Lane, 21> information_;
  std::array<Lane, 6> gradient_;
  Lane cost_ = Lane::Zero();
};

PoseObservationBatches::PoseObservationBatches(const ProjectionModel& model,
                                               std::span<const PoseObservation> observations)
    : model_(model), batches_((observations.size() + kLanes - 1) / kLanes), size_(observations.size()) {
  for (size_t i = 0; i < size_; ++i) {
    if (IsUsable(observations[i])) Fill(observations[i], static_cast<int>(i % kLanes), &batches_[i / kLanes]);
  }
}

void PoseObservationBatches::Fill(const PoseObservation& observation, int lane, Batch* batch) {
  const PixelObservation& pixel = observation.pixel;
  batch->x(lane) = observation.point_in_map.x();
  batch->y(lane) = observation.point_in_map.y();
  batch->z(lane) = observation.point_in_map.z();
  batch->u(lane) = pixel.u;
  batch->v(lane) = pixel.v;
  batch->u_right(lane) = pixel.u_right;
  batch->inverse_sigma2(lane) = pixel.inverse_sigma2;
  batch->chi2_bound(lane) = Chi2Bound(pixel);
  batch->stereo(lane) = pixel.IsStereo() ? 1 : 0;
  batch->usable(lane) = 1;
  batch->active(lane) = 1;
  any_stereo_ = any_stereo_ || pixel.IsStereo();
  ++usable_;
}

PoseObservationBatches::Pose PoseObservationBatches::PoseOf(const SE3& camera_from_map) {
  return {camera_from_map.RotationMatrix(), camera_from_map.translation()};
}

PoseObservationBatches::Projection PoseObservationBatches::Project(const Pose& pose,
                                                                   const Batch& batch) const {
  const Eigen::Matrix3d& r = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  const Lane x = r(0, 0) * batch.x + r(0, 1) * batch.y + r(0, 2) * batch.z + t.x();
  const Lane y = r(1, 0) * batch.x + r(1, 1) * batch.y + r(1, 2) * batch.z + t.y();
  const Lane z = r(2, 0) * batch.x + r(2, 1) * batch.y + r(2, 2) * batch.z + t.z();
  Projection projection;
  projection.in_front = z > kMinDepth;
  projection.inverse_z = projection.in_front.select(z.max(kMinDepth).inverse(), 0.0);
  projection.x = x * projection.inverse_z;
  projection.y = y * projection.inverse_z;
  projection.error_u = model_.fx * projection.x + (model_.cx - batch.u);
  projection.error_v = model_.fy * projection.y + (model_.cy - batch.v);
  projection.error_right = batch.stereo * (model_.fx * projection.x + (model_.cx - batch.u_right) -
                                           model_.focal_times_baseline * projection.inverse_z);
  projection.chi2 = projection.in_front.select(
      batch.inverse_sigma2 *
          (projection.error_u.square() + projection.error_v.square() + projection.error_right.square()),
      kChi2Behind);
  return projection;
}

// With p the point in the camera and a the gradient of a pixel coordinate with respect to p, the row of a
// left perturbation (translation, rotation) is (a, p x a); written out in X = x/z and Y = y/z.
void PoseObservationBatches::AddBatch(const Batch& batch, const Projection& p, Sums* sums) const {
  // Huber on chi^2: rho = chi2 below the bound, 2 sqrt(bound chi2) - bound above; the weight is its
  // derivative.
  const auto beyond = p.chi2 > batch.chi2_bound;
  const Lane root = (batch.chi2_bound * p.chi2).sqrt();
  sums->AddCost(batch.active * beyond.select(2.0 * root - batch.chi2_bound, p.chi2));
  const Lane robust = beyond.select(batch.chi2_bound / root.max(kMinDepth), 1.0);
  const Lane weight = p.in_front.select(batch.active * batch.inverse_sigma2 * robust, 0.0);

  const Lane xy = p.x * p.y;
  const Lane zero = Lane::Zero();
  const double fx = model_.fx;
  const double fy = model_.fy;
  const std::array<Lane, 6> row_u = {fx * p.inverse_z,       zero,     -fx * p.x * p.inverse_z, -fx * xy,
                                     fx + fx * p.x.square(), -fx * p.y};
  sums->AddRow(row_u, weight, p.error_u);
  const std::array<Lane, 6> row_v = {
      zero, fy * p.inverse_z, -fy * p.y * p.inverse_z, -fy - fy * p.y.square(), fy * xy, fy * p.x};
  sums->AddRow(row_v, weight, p.error_v);
  if (!any_stereo_) return;
  const Lane by_depth = model_.focal_times_baseline * p.inverse_z;
  const std::array<Lane, 6> row_right = {
      row_u[0], zero, row_u[2] + by_depth * p.inverse_z, row_u[3] + by_depth * p.y, row_u[4] - by_depth * p.x,
      row_u[5]};
  sums->AddRow(row_right, weight * batch.stereo, p.error_right);
}

void PoseObservationBatches::Linearize(const SE3& camera_from_map, PoseNormalEquations* equations) const {
  const Pose pose = PoseOf(camera_from_map);
  Sums sums;
  for (const Batch& batch : batches_) AddBatch(batch, Project(pose, batch), &sums);
  *equations = sums.Total();
}

int PoseObservationBatches::ClassifyInliers(const SE3& camera_from_map, bool* changed) {
  const Pose pose = PoseOf(camera_from_map);
  double inliers = 0;
  bool any_change = false;
  for (Batch& batch : batches_) {
    const Projection projection = Project(pose, batch);
    const Lane active =
        (projection.in_front && projection.chi2 <= batch.chi2_bound).select(batch.usable, 0.0);
    any_change = any_change || (active != batch.active).any();
    batch.active = active;
    inliers += active.sum();
  }
  if (changed != nullptr) *changed = any_change;
  return static_cast<int>(inliers);
}

void PoseObservationBatches::CopyOutliers(std::vector<char>* outlier) const {
  outlier->resize(size_);
  for (size_t i = 0; i < size_; ++i) {
    (*outlier)[i] = batches_[i / kLanes].active(static_cast<int>(i % kLanes)) == 0 ? 1 : 0;
  }
}

}  // namespace semmap
