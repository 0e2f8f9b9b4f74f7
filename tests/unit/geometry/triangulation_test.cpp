#include "slam/geometry/triangulation.h"

#include <random>

#include <gtest/gtest.h>

namespace semmap {
namespace {

Eigen::Vector3d Ray(const SE3& camera_from_map, const Eigen::Vector3d& point) {
  const Eigen::Vector3d in_camera = camera_from_map * point;
  return in_camera / in_camera.z();
}

TEST(TriangulateLinear, FindsExactPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 200; ++i) {
    Vector6d motion;
    for (double& value : motion) value = 0.3 * unit(random);
    const SE3 first = SE3::Exp(10 * motion);  // far from the map's origin
    const SE3 second = SE3::Exp(motion) * first;
    const Eigen::Vector3d point =
        first.Inverse() * Eigen::Vector3d(unit(random), unit(random), 4 + unit(random));
    const auto found = TriangulateLinear(first, second, Ray(first, point), Ray(second, point));
    ASSERT_TRUE(found.has_value());
    EXPECT_LT((*found - point).norm(), 1e-7) << i;
  }
}

TEST(TriangulateLinear, IsGoodToThePixelNoise) {
  const SE3 first;
  const SE3 second(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-0.5, 0, 0));
  const Eigen::Vector3d point(0.4, -0.2, 5);
  const double sigma = 1.0 / 700;  // one pixel
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, sigma);
  double squares = 0;
  constexpr int kTrials = 2000;
  for (int i = 0; i < kTrials; ++i) {
    const Eigen::Vector3d jitter_first(noise(random), noise(random), 0);
    const Eigen::Vector3d jitter_second(noise(random), noise(random), 0);
    const auto found = TriangulateLinear(first, second, Ray(first, point) + jitter_first,
                                         Ray(second, point) + jitter_second);
    ASSERT_TRUE(found.has_value());
    squares += std::pow(found->z() - point.z(), 2);
  }
  // Depth error of a stereo pair: z^2 / baseline * sigma of the disparity.
  const double expected = 25 / 0.5 * std::sqrt(2.0) * sigma;
  EXPECT_NEAR(std::sqrt(squares / kTrials), expected, 0.1 * expected);
}

TEST(TriangulateLinear, GivesAPointBehindAsItIs) {
  const SE3 second(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-1, 0, 0));
  const Eigen::Vector3d behind(0.3, 0.2, -4);
  const auto found = TriangulateLinear(SE3(), second, Ray(SE3(), behind), Ray(second, behind));
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((*found - behind).norm(), 1e-9);
}

TEST(TriangulateLinear, DoesNotDependOnTheUnit) {
  for (const double unit : {1e-6, 1e6}) {
    const SE3 second(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-0.1 * unit, 0, 0));
    const Eigen::Vector3d point = unit * Eigen::Vector3d(0.3, 0.2, 40);
    const auto found = TriangulateLinear(SE3(), second, Ray(SE3(), point), Ray(second, point));
    ASSERT_TRUE(found.has_value());
    EXPECT_LT((*found - point).norm(), 1e-6 * unit);
  }
}

TEST(TriangulateLinear, RefusesWhatHasNoPoint) {
  const SE3 second(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-1, 0, 0));
  const Eigen::Vector3d ray(0.1, 0.2, 1);
  EXPECT_FALSE(TriangulateLinear(SE3(), second, ray, ray).has_value()) << "parallel rays";
  EXPECT_FALSE(TriangulateLinear(SE3(), SE3(), ray, ray).has_value()) << "no baseline";
  const SE3 forward(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, -1));
  const Eigen::Vector3d axis(0, 0, 1);
  EXPECT_FALSE(TriangulateLinear(SE3(), forward, axis, axis).has_value()) << "both along the baseline";
}

}  // namespace
}  // namespace semmap
