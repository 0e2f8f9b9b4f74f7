#include "slam/geometry/se3.h"

#include <cmath>

namespace semmap {
namespace {

// Below this angle the series is exact to double precision and the closed forms divide by almost zero.
constexpr double kSmallAngle = 1e-6;

Eigen::Vector3d LogSO3(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1.0 : 1.0;
  const Eigen::Vector3d vector = sign * rotation.vec();
  const double norm = vector.norm();
  if (norm < kSmallAngle) return 2.0 * vector;
  return 2.0 * std::atan2(norm, sign * rotation.w()) / norm * vector;
}

}  // namespace

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d skew;
  skew << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return skew;
}

// Also maps the translational part of a tangent vector to the translation. I + a [phi]x + b [phi]x^2 with
// a = (1 - cos) / angle^2 and b = (angle - sin) / angle^3, in forms that do not cancel for small angles.
Eigen::Matrix3d LeftJacobianSO3(const Eigen::Vector3d& phi) {
  constexpr double kSeriesAngle = 1e-3;  // the next term of the series is below rounding
  const double angle = phi.norm();
  const double square = angle * angle;
  const double half_sinc = angle < kSeriesAngle ? 1.0 - square / 24.0 : std::sin(0.5 * angle) / (0.5 * angle);
  const double a = 0.5 * half_sinc * half_sinc;
  const double b =
      angle < kSeriesAngle ? 1.0 / 6.0 - square / 120.0 : (angle - std::sin(angle)) / (square * angle);
  const Eigen::Matrix3d skew = Skew(phi);
  return Eigen::Matrix3d::Identity() + a * skew + b * skew * skew;
}

Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const double half = 0.5 * angle;
  const double factor = angle < kSmallAngle ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  return {std::cos(half), factor * phi.x(), factor * phi.y(), factor * phi.z()};
}

SE3 SE3::FromMatrix(const Eigen::Matrix4d& matrix) {
  return {Eigen::Matrix3d(matrix.topLeftCorner<3, 3>()), Eigen::Vector3d(matrix.topRightCorner<3, 1>())};
}

SE3 SE3::Exp(const Vector6d& tangent) {
  const Eigen::Vector3d phi = tangent.tail<3>();
  return {ExpSO3(phi), LeftJacobianSO3(phi) * tangent.head<3>()};
}

Vector6d SE3::Log() const {
  const Eigen::Vector3d phi = LogSO3(rotation_);
  Vector6d tangent;
  tangent << LeftJacobianSO3(phi).inverse() * translation_, phi;
  return tangent;
}

Eigen::Matrix4d SE3::Matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = RotationMatrix();
  matrix.topRightCorner<3, 1>() = translation_;
  return matrix;
}

SE3 SE3::Inverse() const {
  const Eigen::Quaterniond inverse = rotation_.conjugate();
  return {inverse, -(inverse * translation_)};
}

SE3 SE3::operator*(const SE3& other) const {
  return {rotation_ * other.rotation_, rotation_ * other.translation_ + translation_};
}

double SE3::RotationAngle() const { return LogSO3(rotation_).norm(); }

bool SE3::IsFinite() const { return rotation_.coeffs().allFinite() && translation_.allFinite(); }

Sim3 Sim3::operator*(const Sim3& other) const {
  const Eigen::Vector3d translation = *this * other.rigid.translation();
  return {scale * other.scale, SE3(rigid.rotation() * other.rigid.rotation(), translation)};
}

Sim3 Sim3::Inverse() const {
  const Eigen::Quaterniond inverse = rigid.rotation().conjugate();
  const Eigen::Vector3d translation = -1.0 / scale * (inverse * rigid.translation());
  return {1.0 / scale, SE3(inverse, translation)};
}

}  // namespace semmap
