#include "slam/features/corner_spread.h"

#include <algorithm>
#include <random>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace semmap {
namespace {

constexpr CornerSpread::Region kRegion{16, 16, 416, 216};

std::vector<Corner> RandomCorners(int count, const CornerSpread::Region& region, int low_score,
                                  int high_score, uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](int low, int high) { return low + static_cast<int>(random() % (high - low)); };
  std::vector<Corner> corners;
  for (int i = 0; i < count; ++i) {
    corners.push_back({static_cast<uint16_t>(uniform(region.min_x, region.max_x)),
                       static_cast<uint16_t>(uniform(region.min_y, region.max_y)),
                       static_cast<uint8_t>(uniform(low_score, high_score))});
  }
  return corners;
}

bool ByPlace(const Corner& a, const Corner& b) {
  return std::tie(a.y, a.x, a.score) < std::tie(b.y, b.x, b.score);
}

std::vector<Corner> Select(const std::vector<Corner>& corners, int wanted, int strong_score = 20) {
  std::vector<Corner> selected;
  CornerSpread().Select(corners, kRegion, wanted, strong_score, &selected);
  return selected;
}

TEST(CornerSpread, TakesNoMoreThanWantedAndNothingTwice) {
  auto corners = RandomCorners(5000, kRegion, 21, 250, 1);
  std::sort(corners.begin(), corners.end(), ByPlace);
  for (const int wanted : {1, 7, 200, 1999}) {
    auto selected = Select(corners, wanted);
    EXPECT_EQ(selected.size(), static_cast<size_t>(wanted));
    std::sort(selected.begin(), selected.end(), ByPlace);
    EXPECT_TRUE(std::includes(corners.begin(), corners.end(), selected.begin(), selected.end(), ByPlace));
  }
  EXPECT_EQ(Select(corners, 6000).size(), 5000u);
  EXPECT_TRUE(Select(corners, 0).empty());
  EXPECT_TRUE(Select({}, 100).empty());
}

TEST(CornerSpread, ACrowdOfStrongCornersDoesNotStarveTheRest) {
  // A thousand strong ones in a corner of the region, a hundred weaker ones everywhere.
  auto corners = RandomCorners(1000, {16, 16, 66, 66}, 150, 250, 2);
  const auto weaker = RandomCorners(100, {66, 66, 416, 216}, 30, 60, 3);
  corners.insert(corners.end(), weaker.begin(), weaker.end());
  const auto selected = Select(corners, 200);
  const auto far = std::count_if(selected.begin(), selected.end(), [](const Corner& c) { return c.x >= 66; });
  EXPECT_GE(far, 75);
}

TEST(CornerSpread, PrefersTheStrongestOfACell) {
  const std::vector<Corner> corners = {{20, 20, 40}, {22, 25, 90}, {25, 21, 60}};
  EXPECT_THAT(Select(corners, 2), testing::ElementsAre(Corner{22, 25, 90}, Corner{25, 21, 60}));
}

TEST(CornerSpread, WeakCornersCountOnlyWhereThereIsNoStrongOne) {
  // Two cells of 200 pixels each.
  const std::vector<Corner> corners = {{20, 20, 30}, {30, 30, 10}, {300, 20, 12}, {310, 90, 9}};
  EXPECT_THAT(Select(corners, 8),
              testing::UnorderedElementsAre(Corner{20, 20, 30}, Corner{300, 20, 12}, Corner{310, 90, 9}));
  // With more cells than that every corner is alone.
  EXPECT_EQ(Select(corners, 8000).size(), 4u);
}

TEST(CornerSpread, OrderOfTheInputIsIrrelevantToTheChoiceByScore) {
  auto corners = RandomCorners(250, kRegion, 21, 250, 4);
  // Distinct scores: no ties to break.
  for (size_t i = 0; i < corners.size(); ++i) corners[i].score = static_cast<uint8_t>(i);
  auto reversed = corners;
  std::reverse(reversed.begin(), reversed.end());
  EXPECT_THAT(Select(reversed, 60, 0), testing::UnorderedElementsAreArray(Select(corners, 60, 0)));
}

}  // namespace
}  // namespace semmap
