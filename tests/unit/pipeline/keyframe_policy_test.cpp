#include "slam/pipeline/keyframe_policy.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

KeyFrameEvidence WeakMono() {
  KeyFrameEvidence evidence;
  evidence.inliers = 100;
  evidence.reference_points = 200;
  evidence.map_keyframes = 10;
  evidence.seconds_since_keyframe = 0.3;
  return evidence;
}

TEST(KeyFramePolicyTest, WeakTrackingAsksForAKeyFrame) { EXPECT_TRUE(IsKeyFrameNeeded({}, WeakMono())); }

TEST(KeyFramePolicyTest, StrongTrackingDoesNot) {
  KeyFrameEvidence evidence = WeakMono();
  evidence.inliers = 195;
  EXPECT_FALSE(IsKeyFrameNeeded({}, evidence));
}

TEST(KeyFramePolicyTest, NearlyLostFrameIsNoGroundToBuildOn) {
  KeyFrameEvidence evidence = WeakMono();
  evidence.inliers = TrackingConfig().min_inliers;
  EXPECT_FALSE(IsKeyFrameNeeded({}, evidence));
}

TEST(KeyFramePolicyTest, BusyMapperWaitsUntilDueOrUrgent) {
  KeyFrameEvidence evidence = WeakMono();
  evidence.mapper_idle = false;
  EXPECT_FALSE(IsKeyFrameNeeded({}, evidence));
  evidence.seconds_since_keyframe = 1.5;
  EXPECT_TRUE(IsKeyFrameNeeded({}, evidence));
  evidence.seconds_since_keyframe = 0.1;
  evidence.inliers = 40;
  EXPECT_TRUE(IsKeyFrameNeeded({}, evidence));
  evidence.mapper_accepts = false;
  EXPECT_FALSE(IsKeyFrameNeeded({}, evidence));
}

TEST(KeyFramePolicyTest, MissingCloseDepthIsUrgent) {
  KeyFrameEvidence evidence = WeakMono();
  evidence.sensor = SensorType::kStereo;
  evidence.inliers = 195;
  evidence.mapper_idle = false;
  evidence.close_tracked = 50;
  evidence.close_untracked = 100;
  EXPECT_TRUE(IsKeyFrameNeeded({}, evidence));
  evidence.close_untracked = 20;
  EXPECT_FALSE(IsKeyFrameNeeded({}, evidence));
}

}  // namespace
}  // namespace semmap
