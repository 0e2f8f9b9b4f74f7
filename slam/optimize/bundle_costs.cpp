#include "slam/optimize/bundle_costs.h"

#include <cmath>
#include <limits>

namespace semmap {
namespace {

// Residual of a point behind the camera: a hundred sigma.
constexpr double kResidualBehind = 100;

template <int kRows, int kColumns>
using RowMajor = Eigen::Matrix<double, kRows, kColumns, Eigen::RowMajor>;

template <int kRows>
Eigen::Matrix<double, kRows, 1> PixelError(const ProjectionModel& model, const Eigen::Vector3d& point,
                                           const PixelObservation& pixel) {
  const double inverse_z = 1.0 / point.z();
  const double u = model.fx * point.x() * inverse_z + model.cx;
  Eigen::Matrix<double, kRows, 1> error;
  error(0) = u - pixel.u;
  error(1) = model.fy * point.y() * inverse_z + model.cy - pixel.v;
  if constexpr (kRows == 3) error(2) = u - model.focal_times_baseline * inverse_z - pixel.u_right;
  return error;
}

// Derivative of the error over sigma by the point in the camera frame.
template <int kRows>
Eigen::Matrix<double, kRows, 3> PixelByPoint(const ProjectionModel& model, const Eigen::Vector3d& point,
                                             double inverse_sigma) {
  const double inverse_z = 1.0 / point.z();
  const double fx = inverse_sigma * model.fx * inverse_z;
  const double fy = inverse_sigma * model.fy * inverse_z;
  Eigen::Matrix<double, kRows, 3> jacobian;
  jacobian.row(0) << fx, 0, -fx * point.x() * inverse_z;
  jacobian.row(1) << 0, fy, -fy * point.y() * inverse_z;
  if constexpr (kRows == 3) {
    jacobian.row(2) = jacobian.row(0);
    jacobian(2, 2) += inverse_sigma * model.focal_times_baseline * inverse_z * inverse_z;
  }
  return jacobian;
}

}  // namespace

ChartedCamera::ChartedCamera(const SE3& initial_camera_from_map)
    : initial_camera_from_map_(initial_camera_from_map) {
  Update();
}

void ChartedCamera::Update() {
  tau_ = chart_.head<3>();
  const Eigen::Vector3d omega = chart_.tail<3>();
  const Eigen::Matrix3d turn = ExpSO3(omega).toRotationMatrix();
  rotation_ = turn * initial_camera_from_map_.RotationMatrix();
  translation_ = turn * initial_camera_from_map_.translation() + tau_;
  rotation_jacobian_ = LeftJacobianSO3(omega);
}

SE3 ChartedCamera::CameraFromMap() const {
  return SE3(ExpSO3(chart_.tail<3>()), chart_.head<3>()) * initial_camera_from_map_;
}

template <int kRows>
ReprojectionError<kRows>::ReprojectionError(const ProjectionModel& model, const ChartedCamera& camera,
                                            const BundleObservation& observation)
    : model_(model),
      camera_(camera),
      observation_(observation),
      inverse_sigma_(std::sqrt(observation.pixel.inverse_sigma2)) {}

template <int kRows>
void ReprojectionError<kRows>::Evaluate(const double* point_in_map, double* residual, double* by_point,
                                        double* by_chart) const {
  const Eigen::Vector3d point =
      camera_.rotation() * Eigen::Map<const Eigen::Vector3d>(point_in_map) + camera_.translation();
  Eigen::Map<Eigen::Matrix<double, kRows, 1>> error(residual);
  const bool in_front = point.z() > kMinDepth;
  if (observation_.outlier || !in_front) {
    error.setZero();
    if (!observation_.outlier) error(0) = kResidualBehind;
    if (by_point != nullptr) Eigen::Map<RowMajor<kRows, 3>>(by_point).setZero();
    if (by_chart != nullptr) Eigen::Map<RowMajor<kRows, 6>>(by_chart).setZero();
    return;
  }
  error = inverse_sigma_ * PixelError<kRows>(model_, point, observation_.pixel);
  if (by_point == nullptr && by_chart == nullptr) return;
  const Eigen::Matrix<double, kRows, 3> by_point_in_camera =
      PixelByPoint<kRows>(model_, point, inverse_sigma_);
  if (by_point != nullptr) {
    Eigen::Map<RowMajor<kRows, 3>>(by_point).noalias() = by_point_in_camera * camera_.rotation();
  }
  if (by_chart != nullptr) {
    Eigen::Map<RowMajor<kRows, 6>> jacobian(by_chart);
    const Eigen::Matrix3d by_omega = -Skew(point - camera_.tau()) * camera_.rotation_jacobian();
    jacobian.template leftCols<3>() = by_point_in_camera;
    jacobian.template rightCols<3>().noalias() = by_point_in_camera * by_omega;
  }
}

double Chi2(const ProjectionModel& model, const ChartedCamera& camera, const Eigen::Vector3d& point_in_map,
            const PixelObservation& pixel) {
  const Eigen::Vector3d point = camera.rotation() * point_in_map + camera.translation();
  if (!(point.z() > kMinDepth)) return std::numeric_limits<double>::infinity();
  const double squared_error = pixel.IsStereo() ? PixelError<3>(model, point, pixel).squaredNorm()
                                                : PixelError<2>(model, point, pixel).squaredNorm();
  return pixel.inverse_sigma2 * squared_error;
}

template class ReprojectionError<2>;
template class ReprojectionError<3>;

}  // namespace semmap
