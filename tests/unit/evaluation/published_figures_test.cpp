// The published runs whose error is known: the evaluator has to agree to three digits.

#include <gtest/gtest.h>

#include "slam/evaluation/ate.h"
#include "slam/evaluation/trajectory_io.h"
#include "tests/unit/evaluation/evaluation_test_util.h"

namespace semmap {
namespace {

class PublishedFigures : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = SharedDataFolder() + "/trajectories";
    if (!std::filesystem::is_directory(folder_)) GTEST_SKIP() << "no shared trajectories at " << folder_;
  }

  std::string folder_;
};

TEST_F(PublishedFigures, Kitti00) {
  const auto truth = ReadKittiTrajectory(folder_ + "/KITTI_00_gt.txt");
  const auto estimate = ReadKittiTrajectory(folder_ + "/KITTI_00_ORB.txt");
  ASSERT_TRUE(truth.ok()) << truth.status();
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto pairs = AssociateByIndex(*truth, *estimate);
  ASSERT_TRUE(pairs.ok()) << pairs.status();
  const auto ate = ComputeAte(*pairs, Alignment::kSe3);
  ASSERT_TRUE(ate.ok()) << ate.status();
  EXPECT_EQ(ate->translation_m.count, 4541U);
  EXPECT_NEAR(ate->translation_m.rmse, 1.303, 0.0005);
  EXPECT_NEAR(ate->translation_m.max, 3.59, 0.005);
}

TEST_F(PublishedFigures, TumDesk) {
  const auto truth = ReadTumTrajectory(folder_ + "/fr2_desk_groundtruth.txt");
  const auto estimate = ReadTumTrajectory(folder_ + "/fr2_desk_ORB.txt");
  ASSERT_TRUE(truth.ok()) << truth.status();
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  const auto pairs = AssociateByTime(*truth, *estimate);
  ASSERT_TRUE(pairs.ok()) << pairs.status();
  const auto ate = ComputeAte(*pairs, Alignment::kSe3);
  ASSERT_TRUE(ate.ok()) << ate.status();
  EXPECT_NEAR(ate->translation_m.rmse, 0.0081, 0.00005);
}

}  // namespace
}  // namespace semmap
