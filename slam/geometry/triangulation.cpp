#include "slam/geometry/triangulation.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace semmap {
namespace {

// With the baseline scaled to one, the point's weight is its inverse distance in baselines: beyond this many
// the rays are parallel to working precision.
constexpr double kMaxDistanceInBaselines = 1e8;
constexpr double kMinBaseline = 1e-12;
// Ratio of the second smallest to the largest eigenvalue of the normal matrix under which the solution is a
// line, not a point: both rays run along the baseline to within a microradian.
constexpr double kMinEigenvalueRatio = 1e-12;

// Rows x p3 - p1 and y p3 - p2 of each view [R | t], the first view being [I | 0].
Eigen::Matrix4d DesignMatrix(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                             const Eigen::Vector3d& ray_first, const Eigen::Vector3d& ray_second) {
  Eigen::Matrix<double, 3, 4> second;
  second << rotation, translation;
  Eigen::Matrix4d design;
  design.row(0) << -1, 0, ray_first.x(), 0;
  design.row(1) << 0, -1, ray_first.y(), 0;
  design.row(2) = ray_second.x() * second.row(2) - second.row(0);
  design.row(3) = ray_second.y() * second.row(2) - second.row(1);
  return design;
}

}  // namespace

std::optional<Eigen::Vector3d> TriangulateLinear(const SE3& first_from_map, const SE3& second_from_map,
                                                 const Eigen::Vector3d& ray_first,
                                                 const Eigen::Vector3d& ray_second) {
  const SE3 map_from_first = first_from_map.Inverse();
  const SE3 second_from_first = second_from_map * map_from_first;
  const double baseline = second_from_first.translation().norm();
  if (!(baseline > kMinBaseline)) return std::nullopt;
  const Eigen::Matrix4d design = DesignMatrix(
      second_from_first.RotationMatrix(), second_from_first.translation() / baseline, ray_first, ray_second);
  // The normal matrix squares the condition number, which unit baselines and unit depths keep small; its
  // eigenvectors cost a third of the SVD.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(design.transpose() * design);
  const Eigen::Vector4d eigenvalues = solver.eigenvalues();
  if (!(eigenvalues(1) > kMinEigenvalueRatio * eigenvalues(3))) return std::nullopt;
  const Eigen::Vector4d point = solver.eigenvectors().col(0);
  if (!(std::abs(point.w()) * kMaxDistanceInBaselines > point.head<3>().norm())) return std::nullopt;
  return map_from_first * Eigen::Vector3d(baseline / point.w() * point.head<3>());
}

}  // namespace semmap
