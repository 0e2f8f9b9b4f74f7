#include "slam/optimize/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/unit/optimize/synthetic_scene.h"

namespace semmap {
namespace {

BundleSceneOptions SmallScene() {
  return {.fixed_cameras = 4, .free_cameras = 6, .points = 300, .observations = 1500};
}

double MaxCameraError(const BundleProblem& problem, const BundleProblem& truth) {
  double worst = 0;
  for (size_t i = 0; i < problem.cameras.size(); ++i) {
    const SE3 error = problem.cameras[i].camera_from_map * truth.cameras[i].camera_from_map.Inverse();
    worst = std::max(worst, error.Log().norm());
  }
  return worst;
}

double MedianPointError(const BundleProblem& problem, const BundleProblem& truth) {
  std::vector<double> errors;
  for (size_t i = 0; i < problem.points.size(); ++i) {
    errors.push_back((problem.points[i] - truth.points[i]).norm());
  }
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  return errors[errors.size() / 2];
}

double DegreesOfFreedom(const BundleProblem& problem) {
  double degrees = -3.0 * static_cast<double>(problem.points.size());
  for (const BundleCamera& camera : problem.cameras) degrees -= camera.fixed ? 0 : 6;
  for (const BundleObservation& observation : problem.observations) {
    degrees += observation.pixel.IsStereo() ? 3 : 2;
  }
  return degrees;
}

TEST(AdjustBundle, RecoversTheExactScene) {
  BundleSceneOptions options = SmallScene();
  options.stereo_fraction = 0.5;
  options.sigma_px = 1e-5;
  BundleScene scene = MakeBundleScene(options, 1);
  for (BundleObservation& observation : scene.problem.observations) observation.pixel.inverse_sigma2 = 1;
  const BundleSummary summary = AdjustBundle({.first_iterations = 30}, &scene.problem);
  EXPECT_LT(MaxCameraError(scene.problem, scene.truth), 1e-3);
  EXPECT_LT(MedianPointError(scene.problem, scene.truth), 1e-2);
  EXPECT_LT(summary.final_cost, 1e-3 * summary.initial_cost);
  EXPECT_EQ(summary.outliers, 0);
}

struct Setting {
  double stereo_fraction;
  double outlier_fraction;
};

class AdjustBundleIn : public testing::TestWithParam<Setting> {};

TEST_P(AdjustBundleIn, RecoversANoisySceneAndMarksOutliers) {
  BundleSceneOptions options = SmallScene();
  options.stereo_fraction = GetParam().stereo_fraction;
  options.outlier_fraction = GetParam().outlier_fraction;
  for (uint32_t seed = 0; seed < 5; ++seed) {
    BundleScene scene = MakeBundleScene(options, seed);
    const double error_before = MaxCameraError(scene.problem, scene.truth);
    const double points_before = MedianPointError(scene.problem, scene.truth);
    const BundleSummary summary = AdjustBundle({}, &scene.problem);
    EXPECT_LT(MaxCameraError(scene.problem, scene.truth), 0.5 * error_before) << seed;
    EXPECT_LT(MedianPointError(scene.problem, scene.truth), 0.6 * points_before) << seed;
    if (GetParam().outlier_fraction == 0) {
      // At the optimum the cost is half a chi^2 of as many degrees of freedom as the parameters leave; Huber
      // takes a little off its tail.
      EXPECT_NEAR(2 * summary.final_cost / DegreesOfFreedom(scene.problem), 0.97, 0.12);
    }
    int missed = 0;
    int total = 0;
    for (size_t i = 0; i < scene.is_outlier.size(); ++i) {
      total += scene.is_outlier[i];
      missed += scene.is_outlier[i] && !scene.problem.observations[i].outlier;
    }
    EXPECT_LE(missed, 0.05 * total);
    const auto marked = std::count_if(scene.problem.observations.begin(), scene.problem.observations.end(),
                                      [](const BundleObservation& o) { return o.outlier; });
    EXPECT_EQ(summary.outliers, marked);
    EXPECT_LT(marked, total + 0.08 * static_cast<double>(scene.is_outlier.size()));
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, AdjustBundleIn,
                         testing::Values(Setting{0, 0}, Setting{1, 0}, Setting{0, 0.05}, Setting{0.6, 0.05}));

TEST(AdjustBundle, KeepsFixedCamerasAndUnseenPoints) {
  BundleScene scene = MakeBundleScene(SmallScene(), 2);
  scene.problem.points.emplace_back(1, 2, 3);
  AdjustBundle({}, &scene.problem);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(scene.problem.cameras[i].camera_from_map.Matrix(),
              scene.truth.cameras[i].camera_from_map.Matrix());
  }
  EXPECT_EQ(scene.problem.points.back(), Eigen::Vector3d(1, 2, 3));
}

TEST(AdjustBundle, IsDeterministicWithOneThread) {
  BundleScene a = MakeBundleScene(SmallScene(), 3);
  BundleScene b = MakeBundleScene(SmallScene(), 3);
  AdjustBundle({}, &a.problem);
  AdjustBundle({}, &b.problem);
  for (size_t i = 0; i < a.problem.points.size(); ++i) ASSERT_EQ(a.problem.points[i], b.problem.points[i]);
  for (size_t i = 0; i < a.problem.cameras.size(); ++i) {
    ASSERT_EQ(a.problem.cameras[i].camera_from_map.Matrix(), b.problem.cameras[i].camera_from_map.Matrix());
  }
}

TEST(AdjustBundle, DoesNotDependOnTheOrderOfObservations) {
  BundleScene a = MakeBundleScene(SmallScene(), 4);
  BundleScene b = MakeBundleScene(SmallScene(), 4);
  std::mt19937 random(5);
  std::shuffle(b.problem.observations.begin(), b.problem.observations.end(), random);
  AdjustBundle({}, &a.problem);
  AdjustBundle({}, &b.problem);
  EXPECT_LT(MaxCameraError(a.problem, b.problem), 1e-6);
}

TEST(AdjustBundle, GivesTheSameWithSeveralThreads) {
  BundleScene a = MakeBundleScene(SmallScene(), 6);
  BundleScene b = MakeBundleScene(SmallScene(), 6);
  AdjustBundle({}, &a.problem);
  AdjustBundle({.threads = 2}, &b.problem);
  EXPECT_LT(MaxCameraError(a.problem, b.problem), 1e-6);
}

TEST(AdjustBundle, SolvesManyCamerasSparsely) {
  BundleScene scene = MakeBundleScene({.fixed_cameras = 2,
                                       .free_cameras = 150,
                                       .points = 2000,
                                       .observations = 14000,
                                       .stereo_fraction = 0.5},
                                      7);
  const double error_before = MaxCameraError(scene.problem, scene.truth);
  AdjustBundle({.first_iterations = 15}, &scene.problem);
  // Odometry along 120 m drifts a little even when every observation is used.
  EXPECT_LT(MaxCameraError(scene.problem, scene.truth), error_before);
  EXPECT_LT(MedianPointError(scene.problem, scene.truth), 0.2);
}

TEST(AdjustBundle, StopsWhenToldTo) {
  BundleScene scene = MakeBundleScene(SmallScene(), 8);
  const BundleProblem before = scene.problem;
  const std::atomic<bool> stop = true;
  const BundleSummary summary = AdjustBundle({.stop = &stop}, &scene.problem);
  EXPECT_TRUE(summary.stopped);
  EXPECT_EQ(summary.iterations, 0);
  EXPECT_EQ(summary.initial_cost, summary.final_cost);
  EXPECT_LT(MaxCameraError(scene.problem, before), 1e-12);
  EXPECT_EQ(scene.problem.points[0], before.points[0]);
}

TEST(AdjustBundle, SetsAsideWhatCannotBeUsed) {
  BundleScene scene = MakeBundleScene(SmallScene(), 9);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<BundleObservation>& observations = scene.problem.observations;
  observations[0].camera = 1000;
  observations[1].point = -1;
  observations[2].pixel.u = kNan;
  observations[3].pixel.inverse_sigma2 = 0;
  const int broken_point = observations[200].point;
  scene.problem.points[broken_point].x() = kNan;
  AdjustBundle({}, &scene.problem);
  for (const int i : {0, 1, 2, 3, 200}) EXPECT_TRUE(observations[i].outlier) << i;
  for (const BundleCamera& camera : scene.problem.cameras) EXPECT_TRUE(camera.camera_from_map.IsFinite());
  scene.problem.points[broken_point] = scene.truth.points[broken_point];
  EXPECT_LT(MedianPointError(scene.problem, scene.truth), 0.2);
}

TEST(AdjustBundle, AcceptsNothingToDo) {
  BundleProblem empty;
  const BundleSummary summary = AdjustBundle({}, &empty);
  EXPECT_EQ(summary.iterations, 0);
  EXPECT_EQ(summary.final_cost, 0);
  BundleScene scene = MakeBundleScene(SmallScene(), 10);
  for (BundleCamera& camera : scene.problem.cameras) camera.fixed = true;
  AdjustBundle({}, &scene.problem);  // points only: cameras are at fault, which must not matter
  EXPECT_EQ(scene.problem.cameras[8].fixed, true);
}

}  // namespace
}  // namespace semmap
