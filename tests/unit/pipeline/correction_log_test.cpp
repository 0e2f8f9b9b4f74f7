#include "slam/pipeline/correction_log.h"

#include <gtest/gtest.h>

#include <limits>

namespace semmap {
namespace {

SE3 At(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 0}}; }

MapDelta TwoKeyFrames() {
  MapDelta delta;
  delta.added_keyframes.resize(2);
  delta.added_keyframes[0].id = KeyFrameId(1);
  delta.added_keyframes[0].sequence = 10;
  delta.added_keyframes[1].id = KeyFrameId(4);
  delta.added_keyframes[1].sequence = 20;
  delta.added_keyframes[1].map_from_camera = At(5);
  return delta;
}

TEST(CorrectionLogTest, TellsWhereReportedPosesAreNow) {
  CorrectionLog log;
  log.Note(TwoKeyFrames());
  MapDelta loop;
  const SE3 turned(ExpSO3({0, 0, 0.5}), {7, 1, 0});
  loop.moved_keyframes = {{KeyFrameId(4), turned, KeyFrameId(1), 2.0}};
  log.Note(loop);
  const auto corrections = log.Corrections();
  ASSERT_EQ(corrections.size(), 2u);
  EXPECT_EQ(corrections[0].from_sequence, 10u);
  EXPECT_EQ(corrections[0].through_sequence, 19u);
  EXPECT_TRUE(
      (corrections[0].corrected_from_reported * Eigen::Vector3d(1, 2, 3)).isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_EQ(corrections[1].from_sequence, 20u);
  EXPECT_EQ(corrections[1].through_sequence, std::numeric_limits<uint64_t>::max());
  // A frame reported one unit ahead of the keyframe is two units ahead of it now, in its new direction.
  const Eigen::Vector3d expected = turned * Eigen::Vector3d(2, 0, 0);
  EXPECT_TRUE((corrections[1].corrected_from_reported * Eigen::Vector3d(6, 0, 0)).isApprox(expected, 1e-12));
}

TEST(CorrectionLogTest, CorrectionsAddUp) {
  CorrectionLog log;
  log.Note(TwoKeyFrames());
  MapDelta loop;
  loop.moved_keyframes = {{KeyFrameId(4), At(6), KeyFrameId(1), 2.0}};
  log.Note(loop);
  loop.moved_keyframes = {{KeyFrameId(4), At(8), KeyFrameId(1), 1.5}};
  log.Note(loop);
  const Eigen::Vector3d now = log.Corrections()[1].corrected_from_reported * Eigen::Vector3d(6, 0, 0);
  EXPECT_TRUE(now.isApprox(Eigen::Vector3d(11, 0, 0), 1e-12));
}

TEST(CorrectionLogTest, FramesOfACulledKeyFrameFollowTheOneBefore) {
  CorrectionLog log;
  log.Note(TwoKeyFrames());
  MapDelta cull;
  cull.removed_keyframes = {{KeyFrameId(4), KeyFrameId(1), At(5)}};
  log.Note(cull);
  ASSERT_EQ(log.Corrections().size(), 1u);
  EXPECT_EQ(log.Corrections()[0].through_sequence, std::numeric_limits<uint64_t>::max());
  MapDelta reset;
  reset.reset = true;
  log.Note(reset);
  EXPECT_TRUE(log.Corrections().empty());
}

}  // namespace
}  // namespace semmap
