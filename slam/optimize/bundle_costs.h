#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include "slam/geometry/se3.h"
#include "slam/optimize/bundle_adjustment.h"
#include "slam/optimize/observation.h"

namespace semmap {

// A camera of a bundle adjustment. Ceres moves it in a chart around its initial pose: six numbers (tau,
// omega) with
//   point_in_camera = Exp(omega) * (initial_camera_from_map * point_in_map) + tau,
// which start at zero. Rotation is about the camera's centre, so the chart stays well conditioned far from
// the map's origin; and without a manifold Ceres has no 6x6 product to make for each observation. What the
// cost functions need is computed by Update once for each evaluation, not once for each observation. Ceres
// holds the address of `chart`: a camera must not move while a problem refers to it.
class ChartedCamera {
 public:
  explicit ChartedCamera(const SE3& initial_camera_from_map);

  double* chart() { return chart_.data(); }
  const double* chart() const { return chart_.data(); }
  // Takes over the chart's present value.
  void Update();
  SE3 CameraFromMap() const;

  const Eigen::Matrix3d& rotation() const { return rotation_; }
  const Eigen::Vector3d& translation() const { return translation_; }
  const Eigen::Vector3d& tau() const { return tau_; }
  // Left Jacobian of SO(3) at omega.
  const Eigen::Matrix3d& rotation_jacobian() const { return rotation_jacobian_; }

 private:
  SE3 initial_camera_from_map_;
  Vector6d chart_ = Vector6d::Zero();
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
  Eigen::Vector3d tau_;
  Eigen::Matrix3d rotation_jacobian_;
};

// Squared reprojection error over sigma^2, of two or three coordinates; infinite behind the camera.
double Chi2(const ProjectionModel& model, const ChartedCamera& camera, const Eigen::Vector3d& point_in_map,
            const PixelObservation& pixel);

// The reprojection error (u, v[, u_right]) over sigma of a point in a camera; kRows is 2 or 3. A point behind
// the camera has a large constant error; an observation marked as outlier has none. Everything given is
// referred to.
template <int kRows>
class ReprojectionError {
 public:
  ReprojectionError(const ProjectionModel& model, const ChartedCamera& camera,
                    const BundleObservation& observation);

  // residual: kRows numbers. by_point (kRows x 3) and by_chart (kRows x 6), row-major, may be null.
  void Evaluate(const double* point_in_map, double* residual, double* by_point, double* by_chart) const;

 private:
  const ProjectionModel& model_;
  const ChartedCamera& camera_;
  const BundleObservation& observation_;
  double inverse_sigma_;
};

// Blocks: point (3), chart of the camera (6). ChartedCamera::Update must have seen the chart before Evaluate.
template <int kRows>
class MovingCameraCost final : public ceres::SizedCostFunction<kRows, 3, 6> {
 public:
  MovingCameraCost(const ProjectionModel& model, const ChartedCamera& camera,
                   const BundleObservation& observation)
      : error_(model, camera, observation) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    error_.Evaluate(parameters[0], residuals, jacobians == nullptr ? nullptr : jacobians[0],
                    jacobians == nullptr ? nullptr : jacobians[1]);
    return true;
  }

 private:
  ReprojectionError<kRows> error_;
};

// Block: point (3).
template <int kRows>
class FixedCameraCost final : public ceres::SizedCostFunction<kRows, 3> {
 public:
  FixedCameraCost(const ProjectionModel& model, const ChartedCamera& camera,
                  const BundleObservation& observation)
      : error_(model, camera, observation) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    error_.Evaluate(parameters[0], residuals, jacobians == nullptr ? nullptr : jacobians[0], nullptr);
    return true;
  }

 private:
  ReprojectionError<kRows> error_;
};

}  // namespace semmap
