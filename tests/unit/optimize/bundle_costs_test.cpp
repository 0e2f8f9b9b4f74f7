#include "slam/optimize/bundle_costs.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/unit/optimize/synthetic_scene.h"

namespace semmap {
namespace {

SE3 SomePose() { return SE3::Exp((Vector6d() << 40, -25, 12, 0.4, -1.2, 0.7).finished()); }

TEST(ChartedCamera, StartsAtItsInitialPose) {
  const ChartedCamera camera(SomePose());
  EXPECT_LT((camera.CameraFromMap() * SomePose().Inverse()).Log().norm(), 1e-12);
}

TEST(ChartedCamera, MatricesAgreeWithThePose) {
  ChartedCamera camera(SomePose());
  const double chart[6] = {0.3, -0.1, 0.2, 0.5, 0.4, -0.3};
  std::copy(chart, chart + 6, camera.chart());
  camera.Update();
  const Eigen::Vector3d point(3, -2, 9);
  const Eigen::Vector3d by_matrices = camera.rotation() * point + camera.translation();
  EXPECT_LT((camera.CameraFromMap() * point - by_matrices).norm(), 1e-12);
  // tau alone moves the camera frame's origin.
  const Eigen::Vector3d turned = ExpSO3({0.5, 0.4, -0.3}) * (SomePose() * point);
  EXPECT_LT((by_matrices - turned - Eigen::Vector3d(0.3, -0.1, 0.2)).norm(), 1e-12);
}

// Parameters are whether the observation is stereo, and how far from the chart's origin.
class ReprojectionErrorAt : public testing::TestWithParam<std::tuple<bool, double>> {
 protected:
  template <int kRows>
  void CheckJacobians(double size) {
    std::mt19937 random(1);
    for (int trial = 0; trial < 20; ++trial) {
      ChartedCamera camera(SomePose());
      Eigen::Map<Vector6d>(camera.chart()) = RandomTangent(size, size, random);
      camera.Update();
      const Eigen::Vector3d in_camera = PointInView(model_, random);
      Eigen::Vector3d point = camera.CameraFromMap().Inverse() * in_camera;
      BundleObservation observation;
      observation.pixel = Observe(model_, in_camera, kRows == 3);
      observation.pixel.inverse_sigma2 = 0.3;
      AddNoise(5, random, &observation.pixel);
      MovingCameraCost<kRows> cost(model_, camera, observation);
      CompareWithDifferences<kRows>(cost, &camera, &point);
    }
  }

  template <int kRows>
  static Eigen::Matrix<double, kRows, 1> Residual(const ceres::CostFunction& cost, ChartedCamera* camera,
                                                  const Eigen::Vector3d& point) {
    camera->Update();
    const double* parameters[] = {point.data(), camera->chart()};
    Eigen::Matrix<double, kRows, 1> residual;
    EXPECT_TRUE(cost.Evaluate(parameters, residual.data(), nullptr));
    return residual;
  }

  template <int kRows>
  static void CompareWithDifferences(const ceres::CostFunction& cost, ChartedCamera* camera,
                                     Eigen::Vector3d* point) {
    Eigen::Matrix<double, kRows, 3, Eigen::RowMajor> by_point;
    Eigen::Matrix<double, kRows, 6, Eigen::RowMajor> by_chart;
    Eigen::Matrix<double, kRows, 1> residual;
    const double* parameters[] = {point->data(), camera->chart()};
    double* jacobians[] = {by_point.data(), by_chart.data()};
    ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
    EXPECT_LT((residual - Residual<kRows>(cost, camera, *point)).norm(), 1e-12);
    for (int i = 0; i < 3; ++i) {
      const auto numeric = Difference<kRows>(cost, camera, point, &(*point)(i));
      EXPECT_LT((by_point.col(i) - numeric).norm(), 1e-6 * by_point.norm()) << "point " << i;
    }
    for (int i = 0; i < 6; ++i) {
      const auto numeric = Difference<kRows>(cost, camera, point, camera->chart() + i);
      EXPECT_LT((by_chart.col(i) - numeric).norm(), 1e-6 * by_chart.norm()) << "chart " << i;
    }
  }

  // Central difference of the residual by one parameter.
  template <int kRows>
  static Eigen::Matrix<double, kRows, 1> Difference(const ceres::CostFunction& cost, ChartedCamera* camera,
                                                    Eigen::Vector3d* point, double* parameter) {
    constexpr double kStep = 1e-5;
    const double value = *parameter;
    *parameter = value + kStep;
    const Eigen::Matrix<double, kRows, 1> above = Residual<kRows>(cost, camera, *point);
    *parameter = value - kStep;
    const Eigen::Matrix<double, kRows, 1> below = Residual<kRows>(cost, camera, *point);
    *parameter = value;
    camera->Update();
    return (above - below) / (2 * kStep);
  }

  ProjectionModel model_ = TestModel();
};

TEST_P(ReprojectionErrorAt, JacobiansAreThoseOfTheResidual) {
  const auto [stereo, size] = GetParam();
  if (stereo) {
    CheckJacobians<3>(size);
  } else {
    CheckJacobians<2>(size);
  }
}

INSTANTIATE_TEST_SUITE_P(Charts, ReprojectionErrorAt,
                         testing::Combine(testing::Bool(), testing::Values(0, 1e-4, 0.02, 0.4)));

TEST(FixedCameraCost, IsTheMovingCamerasCostWithoutTheCamera) {
  const ProjectionModel model = TestModel();
  const ChartedCamera camera(SomePose());
  const Eigen::Vector3d point = SomePose().Inverse() * Eigen::Vector3d(1, 2, 9);
  BundleObservation observation;
  observation.pixel = {.u = 700, .v = 300, .u_right = 650, .inverse_sigma2 = 0.5};
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> fixed_jacobian;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> moving_jacobian;
  Eigen::Vector3d fixed_residual;
  Eigen::Vector3d moving_residual;
  const double* parameters[] = {point.data(), camera.chart()};
  double* fixed_jacobians[] = {fixed_jacobian.data()};
  double* moving_jacobians[] = {moving_jacobian.data(), nullptr};
  FixedCameraCost<3>(model, camera, observation).Evaluate(parameters, fixed_residual.data(), fixed_jacobians);
  MovingCameraCost<3>(model, camera, observation)
      .Evaluate(parameters, moving_residual.data(), moving_jacobians);
  EXPECT_EQ(fixed_residual, moving_residual);
  EXPECT_EQ(fixed_jacobian, moving_jacobian);
  EXPECT_GT(fixed_jacobian.norm(), 1);
  EXPECT_NEAR(fixed_residual.squaredNorm(), Chi2(model, camera, point, observation.pixel), 1e-9);
}

TEST(ReprojectionError, OfAnOutlierIsZero) {
  const ProjectionModel model = TestModel();
  const ChartedCamera camera{SE3()};
  const Eigen::Vector3d point(1, 1, 5);
  BundleObservation observation;
  const FixedCameraCost<2> cost(model, camera, observation);
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> jacobian;
  const double* parameters[] = {point.data()};
  double* jacobians[] = {jacobian.data()};
  cost.Evaluate(parameters, residual.data(), jacobians);
  EXPECT_GT(residual.norm() * jacobian.norm(), 1);
  observation.outlier = true;
  cost.Evaluate(parameters, residual.data(), jacobians);
  EXPECT_EQ(residual.norm(), 0);
  EXPECT_EQ(jacobian.norm(), 0);
}

TEST(ReprojectionError, BehindTheCameraIsLargeAndConstant) {
  const ProjectionModel model = TestModel();
  const ChartedCamera camera{SE3()};
  const Eigen::Vector3d point(1, 1, -5);
  BundleObservation observation;
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> jacobian;
  const double* parameters[] = {point.data()};
  double* jacobians[] = {jacobian.data()};
  FixedCameraCost<2>(model, camera, observation).Evaluate(parameters, residual.data(), jacobians);
  EXPECT_GT(residual.norm(), 50);
  EXPECT_EQ(jacobian.norm(), 0);
  EXPECT_EQ(Chi2(model, camera, point, observation.pixel), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace semmap
