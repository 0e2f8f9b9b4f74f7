#include "slam/geometry/two_view.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "slam/geometry/two_view_models.h"

namespace semmap {
namespace {

CameraIntrinsics KittiCamera() {
  return {.width = 1241, .height = 376, .fx = 718.9, .fy = 718.9, .cx = 607.2, .cy = 185.2};
}

SE3 Motion(double x, double y, double z, double rx, double ry, double rz) {
  return SE3::Exp((Vector6d() << x, y, z, rx, ry, rz).finished());
}

struct Matches {
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
  std::vector<Eigen::Vector3d> points;
};

class Scene {
 public:
  explicit Scene(uint32_t seed) : random_(seed) {}

  // Pixels all over the image at depths given by `depth(ray)`, seen by both cameras with noise.
  template <typename Depth>
  Matches See(const SE3& second_from_first, int count, double sigma, Depth depth) {
    std::uniform_real_distribution<double> u(0, camera_.width);
    std::uniform_real_distribution<double> v(0, camera_.height);
    std::normal_distribution<double> noise(0, sigma);
    Matches matches;
    for (int attempt = 0; attempt < 100 * count && static_cast<int>(matches.first.size()) < count;
         ++attempt) {
      const Eigen::Vector2d pixel(u(random_), v(random_));
      const Eigen::Vector3d ray = RayOfPixel(camera_, pixel);
      const Eigen::Vector3d point = depth(ray) * ray;
      const Eigen::Vector3d moved = second_from_first * point;
      if (point.z() < 1 || moved.z() < 1) continue;
      const Eigen::Vector2d seen = ProjectPinhole(camera_, moved);
      if (seen.x() < 0 || seen.x() > camera_.width || seen.y() < 0 || seen.y() > camera_.height) continue;
      matches.first.push_back(pixel + Eigen::Vector2d(noise(random_), noise(random_)));
      matches.second.push_back(seen + Eigen::Vector2d(noise(random_), noise(random_)));
      matches.points.push_back(point);
    }
    return matches;
  }

  // Depths without order, dense near the camera as in a street.
  Matches SeeGeneral(const SE3& second_from_first, int count, double sigma) {
    std::uniform_real_distribution<double> inverse_depth(1.0 / 50, 1.0 / 5);
    return See(second_from_first, count, sigma,
               [&](const Eigen::Vector3d&) { return 1 / inverse_depth(random_); });
  }

  Matches SeePlane(const SE3& second_from_first, int count, double sigma, const Eigen::Vector3d& normal,
                   double distance) {
    return See(second_from_first, count, sigma,
               [&](const Eigen::Vector3d& ray) { return distance / normal.dot(ray); });
  }

  void SpoilMatches(double fraction, Matches* matches) {
    std::uniform_real_distribution<double> u(0, camera_.width);
    std::uniform_real_distribution<double> v(0, camera_.height);
    const auto count = static_cast<size_t>(fraction * static_cast<double>(matches->second.size()));
    for (size_t i = 0; i < count; ++i) matches->second[i] = {u(random_), v(random_)};
  }

  const CameraIntrinsics& camera() const { return camera_; }

 private:
  CameraIntrinsics camera_ = KittiCamera();
  std::mt19937 random_;
};

double RotationError(const SE3& a, const SE3& b) { return (a.Inverse() * b).RotationAngle(); }

double DirectionError(const SE3& a, const SE3& b) {
  return std::acos(std::min(1.0, a.translation().normalized().dot(b.translation().normalized())));
}

// Points agree up to the scale that the unit translation sets.
void ExpectStructure(const TwoViewReconstruction& result, const Matches& matches, double scale,
                     size_t first_good) {
  std::vector<double> errors;
  for (size_t i = first_good; i < matches.points.size(); ++i) {
    if (!result.points_in_first[i]) continue;
    errors.push_back((scale * *result.points_in_first[i] - matches.points[i]).norm() /
                     matches.points[i].norm());
  }
  ASSERT_GT(errors.size(), 30U);
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.15);
}

TEST(ReconstructTwoViews, GeneralScene) {
  const SE3 motion = Motion(-1.5, 0.1, 0.4, 0.01, -0.05, 0.02);
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Scene scene(seed);
    const Matches matches = scene.SeeGeneral(motion, 400, 1);
    const auto result = ReconstructTwoViews(scene.camera(), matches.first, matches.second, {});
    ASSERT_TRUE(result.has_value()) << seed;
    EXPECT_FALSE(result->from_homography);
    EXPECT_NEAR(result->second_from_first.translation().norm(), 1, 1e-12);
    EXPECT_LT(RotationError(result->second_from_first, motion), 0.01) << seed;
    EXPECT_LT(DirectionError(result->second_from_first, motion), 0.1) << seed;
    ExpectStructure(*result, matches, motion.translation().norm(), 0);
  }
}

TEST(ReconstructTwoViews, WithoutNoiseIsExact) {
  const SE3 motion = Motion(-1.5, 0.1, 0.4, 0.01, -0.05, 0.02);
  Scene scene(1);
  const Matches matches = scene.SeeGeneral(motion, 200, 0);
  const auto result = ReconstructTwoViews(scene.camera(), matches.first, matches.second, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_LT(RotationError(result->second_from_first, motion), 1e-6);
  EXPECT_LT(DirectionError(result->second_from_first, motion), 1e-6);
  EXPECT_GT(result->good_points, 150);
  int good = 0;
  for (size_t i = 0; i < matches.points.size(); ++i) {
    if (!result->points_in_first[i]) continue;
    ++good;
    const Eigen::Vector3d scaled = motion.translation().norm() * *result->points_in_first[i];
    EXPECT_LT((scaled - matches.points[i]).norm(), 1e-4 * matches.points[i].norm());
  }
  EXPECT_EQ(good, result->good_points);
}

TEST(ReconstructTwoViews, PlanarScene) {
  const SE3 motion = Motion(-2, 0.2, 0.5, 0.02, 0.1, 0.01);
  const Eigen::Vector3d normal = Eigen::Vector3d(0.4, 0.2, 1).normalized();
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Scene scene(seed);
    const Matches matches = scene.SeePlane(motion, 400, 0.5, normal, 10);
    const auto result = ReconstructTwoViews(scene.camera(), matches.first, matches.second, {});
    ASSERT_TRUE(result.has_value()) << seed;
    EXPECT_TRUE(result->from_homography);
    EXPECT_LT(RotationError(result->second_from_first, motion), 0.015) << seed;
    EXPECT_LT(DirectionError(result->second_from_first, motion), 0.12) << seed;
    ExpectStructure(*result, matches, motion.translation().norm(), 0);
  }
}

TEST(ReconstructTwoViews, ForwardMotionInAStreet) {
  // Ground 1.65 m below, walls at 8 m on both sides, as far as 60 m; two metres ahead with a slight turn.
  const SE3 motion = Motion(0.02, 0, -2, 0, 0.01, 0);
  const auto street = [](const Eigen::Vector3d& ray) {
    double depth = 60;
    if (ray.y() > 0) depth = std::min(depth, 1.65 / ray.y());
    if (ray.x() != 0) depth = std::min(depth, 8 / std::abs(ray.x()));
    return depth;
  };
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Scene scene(seed);
    const Matches matches = scene.See(motion, 800, 0.5, street);
    const auto result = ReconstructTwoViews(scene.camera(), matches.first, matches.second, {});
    ASSERT_TRUE(result.has_value()) << seed;
    EXPECT_LT(RotationError(result->second_from_first, motion), 0.01) << seed;
    EXPECT_LT(DirectionError(result->second_from_first, motion), 0.1) << seed;
    ExpectStructure(*result, matches, motion.translation().norm(), 0);
  }
}

TEST(ReconstructTwoViews, EnduresOutliers) {
  const SE3 motion = Motion(-1.5, 0.1, 0.4, 0.01, -0.05, 0.02);
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Scene scene(seed);
    Matches matches = scene.SeeGeneral(motion, 500, 1);
    scene.SpoilMatches(0.4, &matches);
    const auto result =
        ReconstructTwoViews(scene.camera(), matches.first, matches.second, {.iterations = 500});
    ASSERT_TRUE(result.has_value()) << seed;
    EXPECT_LT(RotationError(result->second_from_first, motion), 0.015) << seed;
    EXPECT_LT(DirectionError(result->second_from_first, motion), 0.15) << seed;
    ExpectStructure(*result, matches, motion.translation().norm(), 200);
    int wrong = 0;
    for (int i = 0; i < 200; ++i) wrong += result->points_in_first[i].has_value();
    EXPECT_LT(wrong, 12);  // random matches that happen to lie on their epipolar lines
  }
}

TEST(ReconstructTwoViews, RefusesPureRotation) {
  const SE3 motion = Motion(0, 0, 0, 0.02, 0.15, 0.01);
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Scene scene(seed);
    const Matches matches = scene.SeeGeneral(motion, 500, 1);
    EXPECT_FALSE(ReconstructTwoViews(scene.camera(), matches.first, matches.second, {}).has_value()) << seed;
  }
}

TEST(ReconstructTwoViews, RefusesLowParallax) {
  const SE3 motion = Motion(-0.05, 0, 0, 0.001, 0.002, 0);
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Scene scene(seed);
    const Matches matches = scene.SeeGeneral(motion, 500, 1);
    EXPECT_FALSE(ReconstructTwoViews(scene.camera(), matches.first, matches.second, {}).has_value()) << seed;
  }
}

TEST(ReconstructTwoViews, RefusesRandomMatches) {
  for (uint32_t seed = 0; seed < 10; ++seed) {
    Scene scene(seed);
    Matches matches = scene.SeeGeneral(Motion(-1, 0, 0, 0, 0, 0), 300, 1);
    scene.SpoilMatches(1, &matches);
    EXPECT_FALSE(ReconstructTwoViews(scene.camera(), matches.first, matches.second, {}).has_value()) << seed;
  }
}

TEST(ReconstructTwoViews, RefusesTooFewAndDegenerateMatches) {
  Scene scene(1);
  Matches matches = scene.SeeGeneral(Motion(-1, 0, 0, 0, 0, 0), 7, 1);
  EXPECT_FALSE(ReconstructTwoViews(scene.camera(), matches.first, matches.second, {}).has_value());
  EXPECT_FALSE(ReconstructTwoViews(scene.camera(), {}, {}, {}).has_value());
  const std::vector<Eigen::Vector2d> same(100, Eigen::Vector2d(300, 200));
  EXPECT_FALSE(ReconstructTwoViews(scene.camera(), same, same, {}).has_value());
}

TEST(ReconstructTwoViews, IsDeterministic) {
  const SE3 motion = Motion(-1.5, 0.1, 0.4, 0.01, -0.05, 0.02);
  Scene scene(3);
  Matches matches = scene.SeeGeneral(motion, 400, 1);
  scene.SpoilMatches(0.2, &matches);
  const auto a = ReconstructTwoViews(scene.camera(), matches.first, matches.second, {.seed = 5});
  const auto b = ReconstructTwoViews(scene.camera(), matches.first, matches.second, {.seed = 5});
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_EQ(a->second_from_first.Matrix(), b->second_from_first.Matrix());
  EXPECT_EQ(a->points_in_first, b->points_in_first);
}

TEST(EstimateTwoViewModel, ScoresFollowThePaper) {
  // One match exact, one off by 2 px along its epipolar line's normal, one far off.
  TwoViewModel model;
  model.matrix = Eigen::Matrix3d::Identity();
  const std::vector<Eigen::Vector2d> first = {{10, 10}, {20, 20}, {30, 30}};
  const std::vector<Eigen::Vector2d> second = {{10, 10}, {22, 20}, {80, 30}};
  ScoreTwoViewModel(TwoViewModelKind::kHomography, first, second, 1, &model);
  EXPECT_NEAR(model.score, 2 * 5.991 + 2 * (5.991 - 4), 1e-9);
  EXPECT_EQ(model.inliers, 2);
  EXPECT_EQ(model.inlier, (std::vector<char>{1, 1, 0}));
  // Sideways motion: epipolar lines are the image rows.
  model.matrix << 0, 0, 0, 0, 0, -1, 0, 1, 0;
  const std::vector<Eigen::Vector2d> shifted = {{99, 10}, {22, 21}, {80, 32}};
  ScoreTwoViewModel(TwoViewModelKind::kFundamental, first, shifted, 1, &model);
  EXPECT_NEAR(model.score, 2 * 5.991 + 2 * (5.991 - 1), 1e-9);
  EXPECT_EQ(model.inliers, 2);
}

}  // namespace
}  // namespace semmap
