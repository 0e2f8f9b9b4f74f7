#include "slam/evaluation/association.h"

#include <gtest/gtest.h>

#include "tests/unit/evaluation/evaluation_test_util.h"

namespace semmap {
namespace {

constexpr TimestampNs kMs = 1'000'000;

TEST(MatchTimes, PrefersTheClosestAndUsesEachOnce) {
  // 100 is near both 98 and 103; 98 is nearer, so 103 goes to 110 although 100 is nearer to it.
  const auto matches = MatchTimes({100 * kMs, 110 * kMs}, {98 * kMs, 103 * kMs}, 0.02);
  ASSERT_EQ(matches.size(), 2U);
  EXPECT_EQ(matches[0].first, 0U);
  EXPECT_EQ(matches[0].second, 0U);
  EXPECT_EQ(matches[1].first, 1U);
  EXPECT_EQ(matches[1].second, 1U);
}

TEST(MatchTimes, HoldsTheLargestDifference) {
  EXPECT_EQ(MatchTimes({0}, {20 * kMs}, 0.02).size(), 1U);
  EXPECT_TRUE(MatchTimes({0}, {21 * kMs}, 0.02).empty());
  EXPECT_TRUE(MatchTimes({}, {1}, 0.02).empty());
}

TEST(AssociateByTime, LeavesOutWhatHasNoPartner) {
  const Trajectory reference = BendTrajectory(10);
  Trajectory estimate = BendTrajectory(10);
  estimate.poses.erase(estimate.poses.begin() + 4);
  for (StampedPose& pose : estimate.poses) pose.timestamp += 5 * kMs;
  const auto pairs = AssociateByTime(reference, estimate);
  ASSERT_TRUE(pairs.ok()) << pairs.status();
  ASSERT_EQ(pairs->size(), 9U);
  EXPECT_EQ((*pairs)[4].reference_index, 5U);
  EXPECT_EQ((*pairs)[4].estimate_index, 4U);
  EXPECT_EQ((*pairs)[4].timestamp, 505 * kMs);
}

TEST(AssociateByTime, SaysWhyNothingMatches) {
  Trajectory reference = BendTrajectory(10);
  Trajectory estimate = BendTrajectory(10);
  for (StampedPose& pose : estimate.poses) pose.timestamp += 1000'000 * kMs;
  EXPECT_EQ(AssociateByTime(reference, estimate).status().code(), absl::StatusCode::kFailedPrecondition);
  reference.timed = false;
  EXPECT_EQ(AssociateByTime(reference, estimate).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(AssociateByIndex, RefusesHoles) {
  EXPECT_EQ(AssociateByIndex(BendTrajectory(10), BendTrajectory(9)).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(AssociateByIndex(BendTrajectory(10), BendTrajectory(10))->size(), 10U);
}

}  // namespace
}  // namespace semmap
