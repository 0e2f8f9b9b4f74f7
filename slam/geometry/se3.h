#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace semmap {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The matrix [v]x with [v]x w = v x w.
Eigen::Matrix3d Skew(const Eigen::Vector3d& v);

// Exponential map of so(3) and its left Jacobian: Exp(phi + d) = Exp(LeftJacobian(phi) d) Exp(phi) to first
// order.
Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& phi);
Eigen::Matrix3d LeftJacobianSO3(const Eigen::Vector3d& phi);

// A rigid motion, used as a value. A variable names both frames right to left: `map_from_camera *
// point_in_camera` is a point in the map frame. Tangent vectors are (translation, rotation), metres and
// radians.
class SE3 {
 public:
  SE3() : rotation_(Eigen::Quaterniond::Identity()), translation_(Eigen::Vector3d::Zero()) {}
  SE3(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : rotation_(rotation.normalized()), translation_(translation) {}
  SE3(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation)
      : SE3(Eigen::Quaterniond(rotation), translation) {}

  // Takes a rotation that is a unit quaternion already as it is, to the last bit: for what was stored.
  static SE3 FromUnitQuaternion(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation) {
    SE3 result;
    result.rotation_ = rotation;
    result.translation_ = translation;
    return result;
  }
  static SE3 FromMatrix(const Eigen::Matrix4d& matrix);
  // Exponential map of se(3).
  static SE3 Exp(const Vector6d& tangent);
  // Inverse of Exp; the rotation angle is in [0, pi].
  Vector6d Log() const;

  const Eigen::Quaterniond& rotation() const { return rotation_; }
  const Eigen::Vector3d& translation() const { return translation_; }
  Eigen::Matrix3d RotationMatrix() const { return rotation_.toRotationMatrix(); }
  Eigen::Matrix4d Matrix() const;

  SE3 Inverse() const;
  SE3 operator*(const SE3& other) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return rotation_ * point + translation_; }

  // Angle of the rotation, in [0, pi].
  double RotationAngle() const;
  bool IsFinite() const;

 private:
  Eigen::Quaterniond rotation_;
  Eigen::Vector3d translation_;
};

// A similarity: point_out = scale * rotation * point + translation.
struct Sim3 {
  double scale = 1.0;
  SE3 rigid;

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return scale * (rigid.rotation() * point) + rigid.translation();
  }
  Sim3 operator*(const Sim3& other) const;
  // The scale must not be zero.
  Sim3 Inverse() const;
};

}  // namespace semmap
