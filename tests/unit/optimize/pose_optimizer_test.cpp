#include "slam/optimize/pose_optimizer.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "slam/optimize/pose_normal_equations.h"
#include "tests/unit/optimize/synthetic_scene.h"

namespace semmap {
namespace {

// Error of an estimate in the tangent that PoseEstimate::covariance is about.
Vector6d RightError(const SE3& estimate_camera_from_map, const SE3& true_camera_from_map) {
  return (estimate_camera_from_map * true_camera_from_map.Inverse()).Log();
}

// Residuals divided by sigma, from the definition of the model.
Eigen::VectorXd Residuals(const PoseScene& scene, const SE3& camera_from_map) {
  Eigen::VectorXd residuals(3 * scene.observations.size());
  residuals.setZero();
  for (size_t i = 0; i < scene.observations.size(); ++i) {
    const PixelObservation& seen = scene.observations[i].pixel;
    const PixelObservation expected =
        Observe(scene.model, camera_from_map * scene.observations[i].point_in_map, seen.IsStereo());
    const double weight = std::sqrt(seen.inverse_sigma2);
    residuals(3 * i) = weight * (expected.u - seen.u);
    residuals(3 * i + 1) = weight * (expected.v - seen.v);
    if (seen.IsStereo()) residuals(3 * i + 2) = weight * (expected.u_right - seen.u_right);
  }
  return residuals;
}

double RobustCost(const PoseScene& scene, const SE3& camera_from_map) {
  const Eigen::VectorXd residuals = Residuals(scene, camera_from_map);
  double cost = 0;
  for (size_t i = 0; i < scene.observations.size(); ++i) {
    const double chi2 = residuals.segment<3>(3 * i).squaredNorm();
    const double bound = Chi2Bound(scene.observations[i].pixel);
    cost += 0.5 * (chi2 > bound ? 2 * std::sqrt(bound * chi2) - bound : chi2);
  }
  return cost;
}

TEST(PoseNormalEquations, InformationIsJacobianSquared) {
  const PoseScene scene = MakePoseScene({.points = 37, .sigma_px = 1e-3}, 1);  // 37: with padding
  const PoseObservationBatches batches(scene.model, scene.observations);
  PoseNormalEquations equations;
  batches.Linearize(scene.camera_from_map, &equations);
  Eigen::MatrixXd jacobian(3 * scene.observations.size(), 6);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const Vector6d delta = kStep * Vector6d::Unit(i);
    jacobian.col(i) = (Residuals(scene, SE3::Exp(delta) * scene.camera_from_map) -
                       Residuals(scene, SE3::Exp(-delta) * scene.camera_from_map)) /
                      (2 * kStep);
  }
  // All observations are inside their bounds only if the noise is that of their sigma; drop the others' rows.
  const Eigen::VectorXd residuals = Residuals(scene, scene.camera_from_map);
  for (size_t i = 0; i < scene.observations.size(); ++i) {
    const double chi2 = residuals.segment<3>(3 * i).squaredNorm();
    const double bound = Chi2Bound(scene.observations[i].pixel);
    if (chi2 > bound) jacobian.middleRows(3 * i, 3) *= std::pow(bound / chi2, 0.25);
  }
  const Matrix6d expected = jacobian.transpose() * jacobian;
  EXPECT_LT((equations.information - expected).norm(), 1e-6 * expected.norm());
}

TEST(PoseNormalEquations, GradientIsThatOfTheRobustCost) {
  const PoseScene scene = MakePoseScene({.points = 60, .outlier_fraction = 0.2}, 2);
  const PoseObservationBatches batches(scene.model, scene.observations);
  std::mt19937 random(3);
  const SE3 pose = SE3::Exp(RandomTangent(0.02, 0.002, random)) * scene.camera_from_map;
  PoseNormalEquations equations;
  batches.Linearize(pose, &equations);
  EXPECT_NEAR(equations.cost, RobustCost(scene, pose), 1e-9 * equations.cost);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const Vector6d delta = kStep * Vector6d::Unit(i);
    const double numeric =
        (RobustCost(scene, SE3::Exp(delta) * pose) - RobustCost(scene, SE3::Exp(-delta) * pose)) /
        (2 * kStep);
    EXPECT_NEAR(equations.gradient(i), numeric, 1e-5 * equations.gradient.norm());
  }
}

TEST(PoseNormalEquations, PointsBehindHaveCostButNoGradient) {
  PoseScene scene = MakePoseScene({.points = 1}, 4);
  scene.observations[0].point_in_map = scene.camera_from_map.Inverse() * Eigen::Vector3d(1, 0, -5);
  PoseNormalEquations equations;
  PoseObservationBatches(scene.model, scene.observations).Linearize(scene.camera_from_map, &equations);
  EXPECT_GT(equations.cost, 10);
  EXPECT_EQ(equations.gradient.norm(), 0);
  EXPECT_EQ(equations.information.norm(), 0);
}

struct Setting {
  double stereo_fraction;
  double outlier_fraction;
};

class OptimizePoseIn : public testing::TestWithParam<Setting> {};

TEST_P(OptimizePoseIn, RecoversThePoseAndSortsOutliers) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    const PoseScene scene = MakePoseScene(
        {.stereo_fraction = GetParam().stereo_fraction, .outlier_fraction = GetParam().outlier_fraction},
        seed);
    std::mt19937 random(seed + 100);
    const SE3 initial = SE3::Exp(RandomTangent(0.1, 0.01, random)) * scene.camera_from_map;
    std::vector<char> outlier;
    const PoseEstimate estimate = OptimizePose(scene.model, initial, scene.observations, &outlier);
    const Vector6d error = RightError(estimate.camera_from_map, scene.camera_from_map);
    EXPECT_LT(error.head<3>().norm(), 0.06) << seed;
    EXPECT_LT(error.tail<3>().norm(), 0.006) << seed;
    ASSERT_EQ(outlier.size(), scene.observations.size());
    const auto wrong = static_cast<size_t>(GetParam().outlier_fraction * 300);
    size_t found = 0;
    for (size_t i = 0; i < outlier.size(); ++i) found += outlier[i];
    for (size_t i = 0; i < wrong; ++i) EXPECT_TRUE(outlier[i]) << i;
    // One in twenty good ones is beyond a 95 % bound.
    EXPECT_LT(found, wrong + 40);
    EXPECT_EQ(estimate.inliers, static_cast<int>(outlier.size() - found));
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, OptimizePoseIn,
                         testing::Values(Setting{0, 0}, Setting{1, 0}, Setting{0.5, 0.1}, Setting{0, 0.3},
                                         Setting{1, 0.3}));

// Normalized estimation error squared: its mean over trials is 6 when the covariance tells the truth.
double MeanNees(double stereo_fraction, int points) {
  constexpr int kTrials = 300;
  double sum = 0;
  for (uint32_t seed = 0; seed < kTrials; ++seed) {
    const PoseScene scene =
        MakePoseScene({.points = points, .stereo_fraction = stereo_fraction}, 1000 + seed);
    std::vector<char> outlier;
    const PoseEstimate estimate =
        OptimizePose(scene.model, scene.camera_from_map, scene.observations, &outlier);
    const Vector6d error = RightError(estimate.camera_from_map, scene.camera_from_map);
    sum += error.dot(estimate.covariance.ldlt().solve(error));
  }
  return sum / kTrials;
}

TEST(OptimizePose, CovarianceAgreesWithMonteCarlo) {
  for (const double stereo_fraction : {0.0, 0.5, 1.0}) {
    const double nees = MeanNees(stereo_fraction, 150);
    // 6 +- 3 * sqrt(12 / 300) for a perfect model. The 5 % of good observations that are sorted out bring the
    // estimate no information and bias the rest a little, so the truth may be somewhat worse.
    EXPECT_GT(nees, 5.2) << stereo_fraction;
    EXPECT_LT(nees, 7.6) << stereo_fraction;
  }
}

TEST(OptimizePose, CovarianceIsInTheCameraFrame) {
  // All points far ahead along the camera's z: depth of the camera is the least certain direction by far, and
  // that is the camera's z axis whatever the map's axes are.
  PoseScene scene;
  scene.camera_from_map = SE3::Exp((Vector6d() << 3, -2, 1, 0.3, 1.9, -0.4).finished());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d point(2 * uniform(random), 2 * uniform(random), 20 + uniform(random));
    scene.observations.push_back(
        {scene.camera_from_map.Inverse() * point, Observe(scene.model, point, false)});
  }
  std::vector<char> outlier;
  const PoseEstimate estimate =
      OptimizePose(scene.model, scene.camera_from_map, scene.observations, &outlier);
  // With rotation held, z is known about f x / z worse than x.
  const Matrix6d information = estimate.covariance.inverse();
  EXPECT_GT(information(0, 0), 50 * information(2, 2));
  EXPECT_GT(information(1, 1), 50 * information(2, 2));
}

TEST(OptimizePose, IsDeterministic) {
  const PoseScene scene = MakePoseScene({.outlier_fraction = 0.2}, 6);
  const SE3 initial = SE3::Exp(Vector6d::Constant(0.02)) * scene.camera_from_map;
  std::vector<char> outlier_a;
  std::vector<char> outlier_b;
  const PoseEstimate a = OptimizePose(scene.model, initial, scene.observations, &outlier_a);
  const PoseEstimate b = OptimizePose(scene.model, initial, scene.observations, &outlier_b);
  EXPECT_EQ(a.camera_from_map.Matrix(), b.camera_from_map.Matrix());
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(outlier_a, outlier_b);
}

TEST(OptimizePose, LeavesThePoseWithTooFewInliers) {
  PoseScene scene = MakePoseScene({.points = 3}, 7);
  const SE3 initial = SE3::Exp(Vector6d::Constant(0.001)) * scene.camera_from_map;
  std::vector<char> outlier;
  const PoseEstimate few = OptimizePose(scene.model, initial, scene.observations, &outlier);
  EXPECT_EQ(few.camera_from_map.Matrix(), initial.Matrix());
  EXPECT_LE(few.inliers, 3);
  EXPECT_EQ(outlier.size(), 3U);

  const PoseEstimate none = OptimizePose(scene.model, initial, {}, &outlier);
  EXPECT_EQ(none.camera_from_map.Matrix(), initial.Matrix());
  EXPECT_EQ(none.inliers, 0);
  EXPECT_TRUE(outlier.empty());

  scene = MakePoseScene({.points = 50, .outlier_fraction = 1}, 8);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(0, 1000);
  for (PoseObservation& observation : scene.observations) observation.pixel.u = uniform(random);
  const PoseEstimate junk = OptimizePose(scene.model, initial, scene.observations, &outlier);
  EXPECT_LT(junk.inliers, 15);
  EXPECT_TRUE(junk.camera_from_map.IsFinite());
}

TEST(OptimizePose, IgnoresWhatIsNotFiniteOrBehind) {
  PoseScene scene = MakePoseScene({.points = 100}, 10);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  scene.observations[3].point_in_map.y() = kNan;
  scene.observations[4].pixel.u = kNan;
  scene.observations[5].pixel.inverse_sigma2 = std::numeric_limits<double>::infinity();
  scene.observations[6].point_in_map = scene.camera_from_map.Inverse() * Eigen::Vector3d(0, 0, -10);
  const SE3 initial = SE3::Exp(Vector6d::Constant(0.01)) * scene.camera_from_map;
  std::vector<char> outlier;
  const PoseEstimate estimate = OptimizePose(scene.model, initial, scene.observations, &outlier);
  EXPECT_LT(RightError(estimate.camera_from_map, scene.camera_from_map).norm(), 0.1);
  for (const int i : {3, 4, 5, 6}) EXPECT_TRUE(outlier[i]) << i;
}

TEST(OptimizePose, SurvivesDegenerateGeometry) {
  // Every observation of one point: three directions are free.
  PoseScene scene;
  const Eigen::Vector3d point(1, 0.5, 10);
  for (int i = 0; i < 20; ++i) scene.observations.push_back({point, Observe(scene.model, point, false)});
  std::vector<char> outlier;
  const SE3 initial = SE3::Exp(Vector6d::Constant(0.002));
  const PoseEstimate estimate = OptimizePose(scene.model, initial, scene.observations, &outlier);
  EXPECT_TRUE(estimate.camera_from_map.IsFinite());
  EXPECT_TRUE(estimate.covariance.allFinite());
  EXPECT_EQ(estimate.inliers, 20);
  EXPECT_LT(estimate.camera_from_map.Log().norm(), 0.1);
  EXPECT_GT(estimate.covariance.diagonal().maxCoeff(), 1e3);  // and says so
}

}  // namespace
}  // namespace semmap
