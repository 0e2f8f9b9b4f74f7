#include "slam/geometry/essential.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace semmap {
namespace {

SE3 SomeMotion() {
  const SE3 motion = SE3::Exp((Vector6d() << -1.5, 0.2, 0.6, 0.02, -0.1, 0.05).finished());
  return {motion.rotation(), motion.translation().normalized()};
}

double MotionError(const SE3& a, const SE3& b) {
  return (a.Inverse() * b).RotationAngle() + (a.translation() - b.translation()).norm();
}

double ClosestError(const std::vector<SE3>& motions, const SE3& truth) {
  double best = 10;
  for (const SE3& motion : motions) best = std::min(best, MotionError(motion, truth));
  return best;
}

struct RayMatches {
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> second;
};

RayMatches MakeRays(const SE3& motion, int count, double sigma, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, sigma);
  RayMatches matches;
  for (int i = 0; i < count; ++i) {
    const double depth = 6 + 4 * uniform(random);
    const Eigen::Vector3d point(0.7 * depth * uniform(random), 0.4 * depth * uniform(random), depth);
    const Eigen::Vector3d moved = motion * point;
    const auto jitter = [&] { return Eigen::Vector3d(noise(random), noise(random), 0); };
    matches.first.push_back(point / point.z() + jitter());
    matches.second.push_back(moved / moved.z() + jitter());
  }
  return matches;
}

TEST(MotionsOfEssential, ContainTheMotion) {
  const Eigen::Matrix3d essential = -2.5 * EssentialOfMotion(SomeMotion());
  const std::vector<SE3> motions = MotionsOfEssential(essential);
  EXPECT_EQ(motions.size(), 4U);
  EXPECT_LT(ClosestError(motions, SomeMotion()), 1e-9);
  for (const SE3& motion : motions) {
    EXPECT_NEAR(motion.translation().norm(), 1, 1e-12);
    EXPECT_NEAR(motion.RotationMatrix().determinant(), 1, 1e-12);
    const Eigen::Matrix3d normalized = essential / essential.norm() * std::sqrt(2.0);
    const Eigen::Matrix3d own = EssentialOfMotion(motion);
    EXPECT_LT(std::min((own - normalized).norm(), (own + normalized).norm()), 1e-9);
  }
}

TEST(EssentialOfMotion, IsZeroOnMatches) {
  const RayMatches matches = MakeRays(SomeMotion(), 20, 0, 1);
  for (size_t i = 0; i < matches.first.size(); ++i) {
    EXPECT_NEAR(matches.second[i].dot(EssentialOfMotion(SomeMotion()) * matches.first[i]), 0, 1e-12);
  }
}

TEST(RefineEssential, FindsTheExactMotionFromNearby) {
  const RayMatches matches = MakeRays(SomeMotion(), 40, 0, 2);
  const SE3 off = SE3::Exp((Vector6d() << 0.2, 0.1, -0.1, 0.02, -0.03, 0.02).finished()) * SomeMotion();
  const Eigen::Matrix3d refined =
      RefineEssential(EssentialOfMotion(off), matches.first, matches.second, std::vector<char>(40, 1), 1e-3);
  EXPECT_LT(ClosestError(MotionsOfEssential(refined), SomeMotion()), 1e-5);
}

TEST(RefineEssential, IgnoresWhatIsNotToBeUsedAndEnduresSomeOutliers) {
  RayMatches matches = MakeRays(SomeMotion(), 200, 1e-3, 3);
  std::vector<char> use(200, 1);
  for (int i = 0; i < 60; ++i) {
    matches.second[i].y() += 0.3;
    use[i] = 0;
  }
  for (int i = 60; i < 70; ++i) matches.second[i].y() += 0.02;
  const SE3 off = SE3::Exp((Vector6d() << 0.1, 0.1, 0, 0.01, 0, 0.01).finished()) * SomeMotion();
  const Eigen::Matrix3d refined =
      RefineEssential(EssentialOfMotion(off), matches.first, matches.second, use, 1e-3);
  EXPECT_LT(ClosestError(MotionsOfEssential(refined), SomeMotion()), 0.03);
}

TEST(RefineEssential, AveragesTheNoise) {
  double squares = 0;
  for (uint32_t seed = 0; seed < 30; ++seed) {
    const RayMatches matches = MakeRays(SomeMotion(), 300, 1e-3, seed);
    const Eigen::Matrix3d refined = RefineEssential(EssentialOfMotion(SomeMotion()), matches.first,
                                                    matches.second, std::vector<char>(300, 1), 1e-3);
    squares += std::pow(ClosestError(MotionsOfEssential(refined), SomeMotion()), 2);
  }
  EXPECT_LT(std::sqrt(squares / 30), 0.006);
}

TEST(RefineEssential, LeavesWhatHasNoMatches) {
  const Eigen::Matrix3d essential = EssentialOfMotion(SomeMotion());
  const Eigen::Matrix3d refined = RefineEssential(essential, {}, {}, {}, 1e-3);
  EXPECT_LT(ClosestError(MotionsOfEssential(refined), SomeMotion()), 1e-9);
}

}  // namespace
}  // namespace semmap
