#include "slam/features/feature_grid.h"

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace semmap {
namespace {

std::vector<int> BruteForce(const std::vector<Keypoint>& keypoints, float x, float y, float radius) {
  std::vector<int> found;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    if (std::abs(keypoints[i].x - x) <= radius && std::abs(keypoints[i].y - y) <= radius) {
      found.push_back(static_cast<int>(i));
    }
  }
  return found;
}

std::vector<int> ByGrid(const FeatureGrid& grid, const std::vector<Keypoint>& keypoints, float x, float y,
                        float radius) {
  std::vector<int> found;
  grid.ForEachInWindow(keypoints, x, y, radius, [&](int index) { found.push_back(index); });
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<Keypoint> RandomKeypoints(size_t count, float low, float high, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> coordinate(low, high);
  std::vector<Keypoint> keypoints(count);
  for (Keypoint& keypoint : keypoints) {
    keypoint.x = coordinate(random);
    keypoint.y = coordinate(random);
  }
  return keypoints;
}

TEST(FeatureGrid, FindsWhatBruteForceFinds) {
  // Keypoints and queries also lie outside the bounds.
  const ImageBounds bounds{-20.5F, 3.0F, 641.0F, 402.0F};
  const auto keypoints = RandomKeypoints(3000, -60, 700, 1);
  const FeatureGrid grid(bounds, keypoints);
  std::mt19937 random(2);
  std::uniform_real_distribution<float> coordinate(-80, 720);
  std::uniform_real_distribution<float> radius(0, 60);
  size_t total = 0;
  for (int query = 0; query < 500; ++query) {
    const float x = coordinate(random);
    const float y = coordinate(random);
    const float r = radius(random);
    const auto expected = BruteForce(keypoints, x, y, r);
    ASSERT_EQ(ByGrid(grid, keypoints, x, y, r), expected) << x << " " << y << " " << r;
    total += expected.size();
  }
  EXPECT_GT(total, 1000u);
}

TEST(FeatureGrid, ReassignedGridForgetsWhatItHeld) {
  const ImageBounds bounds{0, 0, 640, 480};
  const auto first = RandomKeypoints(500, 0, 480, 3);
  const auto second = RandomKeypoints(20, 0, 480, 4);
  FeatureGrid grid(bounds, first);
  grid.Assign({0, 0, 320, 480}, second);
  EXPECT_EQ(ByGrid(grid, second, 240, 240, 1000), BruteForce(second, 240, 240, 1000));
  EXPECT_EQ(grid.bounds().max_x, 320.0F);
}

TEST(FeatureGrid, WindowBorderIsInside) {
  std::vector<Keypoint> keypoints(2);
  keypoints[0].x = keypoints[0].y = 100;
  keypoints[1].x = keypoints[1].y = 110.5F;
  const FeatureGrid grid({0, 0, 640, 480}, keypoints);
  EXPECT_THAT(ByGrid(grid, keypoints, 105, 105, 5), testing::ElementsAre(0));
  EXPECT_THAT(ByGrid(grid, keypoints, 100, 100, 10.5F), testing::ElementsAre(0, 1));
}

TEST(FeatureGrid, NothingIsFoundWhereNothingCanBe) {
  const FeatureGrid unassigned;
  EXPECT_TRUE(ByGrid(unassigned, {}, 1, 1, 10).empty());
  const FeatureGrid empty({0, 0, 640, 480}, {});
  EXPECT_TRUE(ByGrid(empty, {}, 1, 1, 1000).empty());

  auto keypoints = RandomKeypoints(10, 0, 400, 5);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  keypoints[3].x = nan;
  const FeatureGrid grid({0, 0, 640, 480}, keypoints);
  EXPECT_EQ(ByGrid(grid, keypoints, 200, 200, 1000).size(), 9u);
  EXPECT_TRUE(ByGrid(grid, keypoints, nan, 200, 10).empty());
  EXPECT_TRUE(ByGrid(grid, keypoints, 200, 200, -1).empty());
  EXPECT_TRUE(ByGrid(grid, keypoints, 200, 200, nan).empty());
}

TEST(FeatureGrid, DegenerateAndHugeBounds) {
  const auto keypoints = RandomKeypoints(100, 0, 400, 6);
  for (const ImageBounds& bounds :
       {ImageBounds{5, 5, 5, 5}, ImageBounds{10, 10, 0, 0}, ImageBounds{-1e6F, -1e6F, 1e6F, 1e6F}}) {
    const FeatureGrid grid(bounds, keypoints);
    EXPECT_EQ(ByGrid(grid, keypoints, 200, 200, 50), BruteForce(keypoints, 200, 200, 50));
  }
}

}  // namespace
}  // namespace semmap
