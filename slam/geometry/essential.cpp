#include "slam/geometry/essential.h"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace semmap {
namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

constexpr int kMaxIterations = 10;
constexpr double kMinRelativeGain = 1e-4;
constexpr double kHuber2 = 3.841;  // 95 % quantile of chi^2, one degree of freedom
constexpr double kInitialDamping = 1e-4;
constexpr double kMaxDamping = 1e3;

// Two unit vectors that span the plane normal to a unit vector: the directions in which it can move.
Eigen::Matrix<double, 3, 2> TangentBasis(const Eigen::Vector3d& direction) {
  Eigen::Index smallest = 0;
  direction.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = direction.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  basis.col(1) = direction.cross(basis.col(0));
  return basis;
}

struct EssentialEquations {
  Matrix5d information = Matrix5d::Zero();
  Vector5d gradient = Vector5d::Zero();
  double cost = 0;
};

class SampsonProblem {
 public:
  SampsonProblem(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second,
                 const std::vector<char>& use, double sigma)
      : first_(first), second_(second), use_(use), inverse_sigma_(1 / sigma) {}

  // Around a motion; the tangent is three of rotation from the left, then two of the translation's direction.
  EssentialEquations Linearize(const SE3& motion) const {
    const Eigen::Matrix3d essential = EssentialOfMotion(motion);
    const std::array<Eigen::Matrix3d, 5> derivatives = DerivativesOfEssential(motion);
    EssentialEquations equations;
    for (size_t i = 0; i < first_.size(); ++i) {
      if (use_[i]) AddMatch(essential, derivatives, first_[i], second_[i], &equations);
    }
    return equations;
  }

  static SE3 Moved(const SE3& motion, const Vector5d& step) {
    const Eigen::Vector3d moved = motion.translation() + TangentBasis(motion.translation()) * step.tail<2>();
    return {ExpSO3(step.head<3>()) * motion.rotation(), moved.normalized()};
  }

 private:
  static std::array<Eigen::Matrix3d, 5> DerivativesOfEssential(const SE3& motion) {
    const Eigen::Matrix3d rotation = motion.RotationMatrix();
    const Eigen::Matrix3d cross = Skew(motion.translation());
    const Eigen::Matrix<double, 3, 2> basis = TangentBasis(motion.translation());
    return {cross * Skew(Eigen::Vector3d::UnitX()) * rotation,
            cross * Skew(Eigen::Vector3d::UnitY()) * rotation,
            cross * Skew(Eigen::Vector3d::UnitZ()) * rotation, Skew(basis.col(0)) * rotation,
            Skew(basis.col(1)) * rotation};
  }

  void AddMatch(const Eigen::Matrix3d& essential, const std::array<Eigen::Matrix3d, 5>& derivatives,
                const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                EssentialEquations* equations) const {
    const Eigen::Vector3d line_second = essential * first;
    const Eigen::Vector3d line_first = essential.transpose() * second;
    const double norm2 = line_second.head<2>().squaredNorm() + line_first.head<2>().squaredNorm();
    if (!(norm2 > 0)) return;
    const double scale = inverse_sigma_ / std::sqrt(norm2);
    const double algebraic = second.dot(line_second);
    const double error = scale * algebraic;
    Vector5d row;
    for (int k = 0; k < 5; ++k) {
      const Eigen::Vector3d by_first = derivatives[k] * first;
      const Eigen::Vector3d by_second = derivatives[k].transpose() * second;
      const double norm_change =
          line_second.head<2>().dot(by_first.head<2>()) + line_first.head<2>().dot(by_second.head<2>());
      row(k) = scale * (second.dot(by_first) - algebraic * norm_change / norm2);
    }
    const double chi2 = error * error;
    const double weight = chi2 > kHuber2 ? std::sqrt(kHuber2 / chi2) : 1.0;
    equations->information += weight * row * row.transpose();
    equations->gradient += weight * error * row;
    equations->cost += chi2 > kHuber2 ? 2 * std::sqrt(kHuber2 * chi2) - kHuber2 : chi2;
  }

  const std::vector<Eigen::Vector3d>& first_;
  const std::vector<Eigen::Vector3d>& second_;
  const std::vector<char>& use_;
  double inverse_sigma_;
};

}  // namespace

std::vector<SE3> MotionsOfEssential(const Eigen::Matrix3d& essential) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d quarter_turn;
  quarter_turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Vector3d translation = svd.matrixU().col(2);
  std::vector<SE3> motions;
  for (const Eigen::Matrix3d& turn : {quarter_turn, Eigen::Matrix3d(quarter_turn.transpose())}) {
    Eigen::Matrix3d rotation = svd.matrixU() * turn * svd.matrixV().transpose();
    if (rotation.determinant() < 0) rotation = -rotation;
    motions.emplace_back(rotation, translation);
    motions.emplace_back(rotation, Eigen::Vector3d(-translation));
  }
  return motions;
}

Eigen::Matrix3d EssentialOfMotion(const SE3& second_from_first) {
  return Skew(second_from_first.translation()) * second_from_first.RotationMatrix();
}

Eigen::Quaterniond BestRotation(const std::vector<Eigen::Vector3d>& first,
                                const std::vector<Eigen::Vector3d>& second, const std::vector<char>& use) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < first.size(); ++i) {
    if (use[i]) covariance += second[i].normalized() * first[i].normalized().transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const bool mirrored = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0;
  const Eigen::Vector3d signs(1, 1, mirrored ? -1 : 1);
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose()));
}

Eigen::Matrix3d RefineEssential(const Eigen::Matrix3d& initial, const std::vector<Eigen::Vector3d>& first,
                                const std::vector<Eigen::Vector3d>& second, const std::vector<char>& use,
                                double sigma) {
  const SampsonProblem problem(first, second, use, sigma);
  // The four motions share one essential matrix up to its sign, which the error does not see.
  SE3 motion = MotionsOfEssential(initial).front();
  EssentialEquations equations = problem.Linearize(motion);
  double damping = kInitialDamping;
  for (int i = 0; i < kMaxIterations && damping < kMaxDamping; ++i) {
    Matrix5d information = equations.information;
    information.diagonal() *= 1 + damping;
    const Vector5d step = information.ldlt().solve(-equations.gradient);
    if (!step.allFinite()) break;
    const SE3 candidate = SampsonProblem::Moved(motion, step);
    const EssentialEquations at_candidate = problem.Linearize(candidate);
    const double gain = equations.cost - at_candidate.cost;
    if (!(gain > 0)) {
      damping *= 20;
      continue;
    }
    const bool converged = gain < kMinRelativeGain * equations.cost;
    motion = candidate;
    equations = at_candidate;
    damping *= 0.1;
    if (converged) break;
  }
  return EssentialOfMotion(motion);
}

}  // namespace semmap
