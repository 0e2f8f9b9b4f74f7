#include "slam/geometry/se3.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

namespace semmap {
namespace {

Vector6d RandomTangent(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Vector6d tangent;
  for (double& value : tangent) value = uniform(random);
  return tangent;
}

TEST(SE3, ExpIsTheMatrixExponential) {
  std::mt19937 random(1);
  for (const double size : {1e-9, 1e-6, 1e-3, 0.1, 1.5}) {
    const Vector6d tangent = RandomTangent(random, size);
    Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
    generator.topLeftCorner<3, 3>() = Skew(tangent.tail<3>());
    generator.topRightCorner<3, 1>() = tangent.head<3>();
    const Eigen::Matrix4d expected = generator.exp();
    EXPECT_LT((SE3::Exp(tangent).Matrix() - expected).norm(), 1e-12) << size;
  }
}

TEST(SE3, LogInvertsExp) {
  std::mt19937 random(2);
  for (const double size : {1e-12, 1e-8, 1e-6, 2e-6, 1e-3, 0.5, 1.7}) {
    for (int i = 0; i < 20; ++i) {
      const Vector6d tangent = RandomTangent(random, size);
      EXPECT_LT((SE3::Exp(tangent).Log() - tangent).norm(), 1e-9 * std::max(1.0, size)) << size;
    }
  }
}

TEST(SE3, LogAngleStaysWithinPi) {
  Vector6d tangent = Vector6d::Zero();
  tangent(4) = 1.5 * std::numbers::pi;
  const Vector6d log = SE3::Exp(tangent).Log();
  EXPECT_NEAR(log(4), -0.5 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(SE3::Exp(tangent).RotationAngle(), 0.5 * std::numbers::pi, 1e-12);
  tangent(4) = std::numbers::pi;
  EXPECT_NEAR(SE3::Exp(tangent).Log().norm(), std::numbers::pi, 1e-9);
}

TEST(SE3, ComposesAsMatricesDo) {
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    const SE3 a = SE3::Exp(RandomTangent(random, 2));
    const SE3 b = SE3::Exp(RandomTangent(random, 2));
    const Eigen::Vector3d point = RandomTangent(random, 5).head<3>();
    EXPECT_LT(((a * b).Matrix() - a.Matrix() * b.Matrix()).norm(), 1e-12);
    EXPECT_LT(((a * b) * point - a * (b * point)).norm(), 1e-12);
    EXPECT_LT((a * a.Inverse()).Log().norm(), 1e-12);
    EXPECT_LT((SE3::FromMatrix(a.Matrix()).Inverse() * a).Log().norm(), 1e-9);
  }
}

TEST(SE3, StaysARotationThroughManyProducts) {
  const SE3 step = SE3::Exp((Vector6d() << 0.1, 0, 0, 0.01, 0.02, -0.03).finished());
  SE3 sum;
  for (int i = 0; i < 100000; ++i) sum = sum * step;
  EXPECT_NEAR(sum.rotation().norm(), 1, 1e-14);
}

TEST(SE3, KnowsWhatIsNotFinite) {
  EXPECT_TRUE(SE3().IsFinite());
  EXPECT_FALSE(SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, 1.0 / 0.0)).IsFinite());
}

TEST(LeftJacobianSO3, IsTheDerivativeOfExp) {
  std::mt19937 random(4);
  constexpr double kStep = 1e-6;
  for (const double size : {0.0, 1e-7, 9e-4, 1.1e-3, 0.3, 1.7}) {
    const Eigen::Vector3d phi = RandomTangent(random, size).head<3>();
    const Eigen::Matrix3d jacobian = LeftJacobianSO3(phi);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const SE3 difference = SE3(ExpSO3(phi + step), Eigen::Vector3d::Zero()) *
                             SE3(ExpSO3(phi - step), Eigen::Vector3d::Zero()).Inverse();
      const Eigen::Vector3d numeric = difference.Log().tail<3>() / (2 * kStep);
      EXPECT_LT((jacobian.col(i) - numeric).norm(), 1e-8) << size;
    }
  }
}

TEST(Skew, IsTheCrossProduct) {
  const Eigen::Vector3d a(1, 2, 3);
  const Eigen::Vector3d b(-4, 0.5, 7);
  EXPECT_LT((Skew(a) * b - a.cross(b)).norm(), 1e-15);
}

TEST(Sim3, ScalesBeforeItMoves) {
  const Sim3 sim3{2, SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(1, 0, 0))};
  EXPECT_EQ(sim3 * Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(3, 2, 2));
}

TEST(Sim3, ComposesAndInverts) {
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) {
    const Sim3 a{0.3 + i, SE3::Exp(RandomTangent(random, 2))};
    const Sim3 b{2.0 / (1 + i), SE3::Exp(RandomTangent(random, 2))};
    const Eigen::Vector3d point = RandomTangent(random, 5).head<3>();
    EXPECT_LT(((a * b) * point - a * (b * point)).norm(), 1e-10);
    EXPECT_LT((a.Inverse() * (a * point) - point).norm(), 1e-10);
    EXPECT_NEAR((a * a.Inverse()).scale, 1, 1e-12);
  }
}

}  // namespace
}  // namespace semmap
