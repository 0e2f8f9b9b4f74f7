#include "slam/optimize/pose_graph_costs.h"

#include <cmath>

#include <Eigen/LU>

namespace semmap {
namespace {

constexpr bool WithScale(int dof) { return dof == 7; }

Eigen::Vector3d RotationVector(const Eigen::Quaterniond& rotation) {
  return SE3(rotation, Eigen::Vector3d::Zero()).Log().tail<3>();
}

}  // namespace

Sim3 ChartedNode::At(const double* chart, bool with_scale) const {
  const Eigen::Map<const Eigen::Vector3d> tau(chart);
  const Eigen::Map<const Eigen::Vector3d> omega(chart + 3);
  const double growth = with_scale ? std::exp(chart[6]) : 1.0;
  return {growth * initial_.scale,
          SE3(ExpSO3(omega) * initial_.rigid.rotation(), initial_.rigid.translation() + tau)};
}

template <int kDof>
bool RelativePoseCost<kDof>::Evaluate(double const* const* parameters, double* residuals,
                                      double** jacobians) const {
  using Jacobian = Eigen::Matrix<double, kDof, kDof, Eigen::RowMajor>;
  const Sim3 from = from_.At(parameters[0], WithScale(kDof));
  const Sim3 to = to_.At(parameters[1], WithScale(kDof));
  const Sim3& measured = edge_.from_from_to;
  const Eigen::Matrix3d from_rotation_inverse = from.rigid.RotationMatrix().transpose() / from.scale;
  const Eigen::Vector3d between = to.rigid.translation() - from.rigid.translation();
  const Eigen::Vector3d seen = from_rotation_inverse * between;
  const Eigen::Vector3d rotation_error = RotationVector(
      measured.rigid.rotation().conjugate() * from.rigid.rotation().conjugate() * to.rigid.rotation());
  Eigen::Matrix<double, kDof, 1> inverse_sigma;
  inverse_sigma.template head<3>().setConstant(1 / edge_.translation_sigma);
  inverse_sigma.template segment<3>(3).setConstant(1 / edge_.rotation_sigma);
  Eigen::Map<Eigen::Matrix<double, kDof, 1>> residual(residuals);
  residual.template head<3>() = seen - measured.rigid.translation();
  residual.template segment<3>(3) = rotation_error;
  if constexpr (WithScale(kDof)) {
    inverse_sigma(6) = 1 / edge_.scale_sigma;
    residual(6) = std::log(to.scale / (from.scale * measured.scale));
  }
  residual.array() *= inverse_sigma.array();
  if (jacobians == nullptr) return true;

  // A change of omega turns the node by LeftJacobian(omega) d from the left; brought to the right of the
  // error it is to_rotation^T times that, and the inverse right Jacobian takes it to the rotation vector.
  const Eigen::Matrix3d to_vector =
      LeftJacobianSO3(-rotation_error).inverse() * to.rigid.RotationMatrix().transpose();
  if (jacobians[0] != nullptr) {
    Eigen::Map<Jacobian> by_from(jacobians[0]);
    const Eigen::Matrix3d turn = LeftJacobianSO3(Eigen::Map<const Eigen::Vector3d>(parameters[0] + 3));
    by_from.setZero();
    by_from.template block<3, 3>(0, 0) = -from_rotation_inverse;
    by_from.template block<3, 3>(0, 3) = from_rotation_inverse * Skew(between) * turn;
    by_from.template block<3, 3>(3, 3) = -to_vector * turn;
    if constexpr (WithScale(kDof)) {
      by_from.template block<3, 1>(0, 6) = -seen;
      by_from(6, 6) = -1;
    }
    by_from = inverse_sigma.asDiagonal() * by_from;
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<Jacobian> by_to(jacobians[1]);
    const Eigen::Matrix3d turn = LeftJacobianSO3(Eigen::Map<const Eigen::Vector3d>(parameters[1] + 3));
    by_to.setZero();
    by_to.template block<3, 3>(0, 0) = from_rotation_inverse;
    by_to.template block<3, 3>(3, 3) = to_vector * turn;
    if constexpr (WithScale(kDof)) by_to(6, 6) = 1;
    by_to = inverse_sigma.asDiagonal() * by_to;
  }
  return true;
}

template class RelativePoseCost<6>;
template class RelativePoseCost<7>;

}  // namespace semmap
