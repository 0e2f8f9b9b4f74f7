#include "slam/geometry/pnp.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace semmap {
namespace {

CameraIntrinsics Camera() {
  return {.width = 752, .height = 480, .fx = 458.7, .fy = 457.3, .cx = 367.2, .cy = 248.4};
}

SE3 TruePose() { return SE3::Exp((Vector6d() << 12, -7, 3, 0.4, -1.9, 1.1).finished()); }

struct Matches {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
};

// The first outlier_fraction of the matches have a random pixel.
Matches MakeMatches(int count, double sigma, double outlier_fraction, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(0, 752);
  std::uniform_real_distribution<double> v(0, 480);
  std::uniform_real_distribution<double> depth(3, 30);
  std::normal_distribution<double> noise(0, sigma);
  const SE3 map_from_camera = TruePose().Inverse();
  Matches matches;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d pixel(u(random), v(random));
    matches.points.push_back(map_from_camera * Eigen::Vector3d(depth(random) * RayOfPixel(Camera(), pixel)));
    const Eigen::Vector2d jitter(noise(random), noise(random));
    const Eigen::Vector2d wrong(u(random), v(random));
    matches.pixels.push_back(i < outlier_fraction * count ? wrong : Eigen::Vector2d(pixel + jitter));
  }
  return matches;
}

Vector6d Error(const PnpResult& result) { return (result.camera_from_map * TruePose().Inverse()).Log(); }

TEST(EstimatePose, IsExactWithoutNoise) {
  const Matches matches = MakeMatches(20, 0, 0, 1);
  const auto result = EstimatePose(Camera(), matches.points, matches.pixels, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_LT(Error(*result).norm(), 1e-5);
  EXPECT_EQ(result->inliers, 20);
}

class EstimatePoseWithOutliers : public testing::TestWithParam<double> {};

TEST_P(EstimatePoseWithOutliers, FindsPoseAndInliers) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    const Matches matches = MakeMatches(150, 1, GetParam(), seed);
    const auto result = EstimatePose(Camera(), matches.points, matches.pixels, {.seed = seed});
    ASSERT_TRUE(result.has_value()) << seed;
    EXPECT_LT(Error(*result).head<3>().norm(), 0.12) << seed;
    EXPECT_LT(Error(*result).tail<3>().norm(), 0.01) << seed;
    ASSERT_EQ(result->inlier.size(), 150U);
    const auto outliers = static_cast<size_t>(GetParam() * 150);
    int wrong = 0;
    int right = 0;
    for (size_t i = 0; i < 150; ++i) (i < outliers ? wrong : right) += result->inlier[i];
    EXPECT_LE(wrong, 2);
    EXPECT_GT(right, 0.95 * static_cast<double>(150 - outliers));
    EXPECT_EQ(result->inliers, wrong + right);
  }
}

INSTANTIATE_TEST_SUITE_P(Fractions, EstimatePoseWithOutliers, testing::Values(0, 0.4, 0.7));

TEST(EstimatePose, SeesAPlaneToo) {
  Matches matches = MakeMatches(100, 0.5, 0.3, 2);
  for (size_t i = 30; i < 100; ++i) {
    const Eigen::Vector3d ray = TruePose() * matches.points[i];
    matches.points[i] = TruePose().Inverse() * Eigen::Vector3d(ray * (10 / (ray.z() + 0.3 * ray.x())));
  }
  const auto result = EstimatePose(Camera(), matches.points, matches.pixels, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_LT(Error(*result).norm(), 0.1);
}

TEST(EstimatePose, IsDeterministic) {
  const Matches matches = MakeMatches(80, 1, 0.5, 3);
  const auto a = EstimatePose(Camera(), matches.points, matches.pixels, {.seed = 9});
  const auto b = EstimatePose(Camera(), matches.points, matches.pixels, {.seed = 9});
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_EQ(a->camera_from_map.Matrix(), b->camera_from_map.Matrix());
  EXPECT_EQ(a->inlier, b->inlier);
}

TEST(EstimatePose, RefusesWhatHasNoPose) {
  const Matches random = MakeMatches(100, 1, 1, 4);
  EXPECT_FALSE(EstimatePose(Camera(), random.points, random.pixels, {.min_inliers = 15}).has_value());
  const Matches few = MakeMatches(9, 0, 0, 5);
  EXPECT_FALSE(EstimatePose(Camera(), few.points, few.pixels, {}).has_value());
  EXPECT_TRUE(EstimatePose(Camera(), few.points, few.pixels, {.min_inliers = 9}).has_value());
  EXPECT_FALSE(EstimatePose(Camera(), few.points, random.pixels, {}).has_value());
  EXPECT_FALSE(EstimatePose(Camera(), {}, {}, {}).has_value());
}

TEST(EstimatePose, SurvivesDegenerateInput) {
  Matches matches = MakeMatches(60, 0.5, 0, 6);
  for (size_t i = 0; i < 20; ++i) matches.points[i].x() = std::numeric_limits<double>::quiet_NaN();
  const auto result = EstimatePose(Camera(), matches.points, matches.pixels, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_LT(Error(*result).norm(), 0.1);
  EXPECT_LE(result->inliers, 40);

  const std::vector<Eigen::Vector3d> one_point(30, Eigen::Vector3d(1, 2, 3));
  const std::vector<Eigen::Vector2d> one_pixel(30, Eigen::Vector2d(100, 100));
  const auto degenerate = EstimatePose(Camera(), one_point, one_pixel, {});
  EXPECT_TRUE(!degenerate.has_value() || degenerate->camera_from_map.IsFinite());
}

}  // namespace
}  // namespace semmap
