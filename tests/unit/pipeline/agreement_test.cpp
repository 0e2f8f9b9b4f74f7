#include "slam/pipeline/agreement.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

TEST(Agreement, TrustIsTheWeakerOfTheTwoShares) {
  const Agreement far_only{.expected = 400, .inliers = 300, .near_expected = 100, .near_inliers = 10};
  EXPECT_DOUBLE_EQ(far_only.Share(), 0.75);
  EXPECT_DOUBLE_EQ(far_only.NearShare(), 0.1);
  EXPECT_DOUBLE_EQ(far_only.Trust(), 0.1);
  const Agreement near_only{.expected = 400, .inliers = 90, .near_expected = 100, .near_inliers = 90};
  EXPECT_DOUBLE_EQ(near_only.Trust(), 0.225);
}

TEST(Agreement, FewNearPointsSayNothing) {
  const Agreement one_eye{.expected = 100, .inliers = 40};
  EXPECT_DOUBLE_EQ(one_eye.Trust(), 0.4);
  const Agreement few{.expected = 100, .inliers = 40, .near_expected = 19, .near_inliers = 0};
  EXPECT_DOUBLE_EQ(few.Trust(), 0.4);
}

TEST(Agreement, NothingExpectedIsNoAgreement) { EXPECT_DOUBLE_EQ(Agreement().Trust(), 0); }

}  // namespace
}  // namespace semmap
