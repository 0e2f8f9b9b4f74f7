// Sessions that begin in a map which was stored before: LOCALIZE and EXTEND.
#include "tests/unit/pipeline/stored_map_fixture.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the room and what is made of it

class LocalizeTest : public StoredMapTest, public ::testing::WithParamInterface<SensorType> {};

TEST_P(LocalizeTest, TracksAnotherLaneFromTheFirstFrameOn) {
  MapCollector told = MakeCollector();
  const CameraRig rig = SmallRig(GetParam());
  const auto session = Localizer(GetParam(), &told);
  const std::vector<SE3> poses = GentleDrive(kMapFrames, kStep);
  for (int i = 0; i < kMapFrames; ++i) {
    const auto result = session->Track(SeeRoom(rig, Beside(poses[i]), i));
    ASSERT_TRUE(result.ok()) << result.status();
    ExpectAt(*result, Beside(poses[i]), kBound);
    EXPECT_EQ(result->map_version, 5U);
    EXPECT_FALSE(result->is_keyframe);
  }
  session->Finish();
  EXPECT_EQ(session->Stats().tracked_frames, static_cast<uint64_t>(kMapFrames));
  EXPECT_EQ(session->Stats().recoveries, 1);
}

TEST_P(LocalizeTest, DeliversItsFramesAndNothingElse) {
  MapCollector told = MakeCollector();
  const CameraRig rig = SmallRig(GetParam());
  const auto session = Localizer(GetParam(), &told);
  const std::vector<SE3> poses = GentleDrive(kMapFrames, kStep);
  for (int i = 0; i < kMapFrames; ++i) ASSERT_TRUE(session->Track(SeeRoom(rig, poses[i], i)).ok());
  session->Finish();
  uint64_t version = 0;
  uint64_t sequence = 0;
  for (const MapDelta& delta : told.deltas()) {
    EXPECT_EQ(delta.version, ++version);
    EXPECT_TRUE(delta.added_keyframes.empty() && delta.moved_keyframes.empty() &&
                delta.upserted_points.empty() && delta.observations.empty() &&
                delta.removed_keyframes.empty() && delta.removed_points.empty() && !delta.reset);
    for (const FramePose& frame : delta.frames) {
      EXPECT_EQ(frame.sequence, ++sequence);
      const auto keyframe = made_->keyframes().find(frame.reference_keyframe);
      ASSERT_NE(keyframe, made_->keyframes().end());
      const SE3 map_from_camera = keyframe->second.map_from_camera * frame.keyframe_from_camera;
      const SE3 error = map_from_camera.Inverse() * MapFromWorld() * poses[sequence - 1];
      EXPECT_LT(error.translation().norm(), kBound) << sequence;
    }
  }
  EXPECT_EQ(sequence, static_cast<uint64_t>(kMapFrames));
}

TEST_P(LocalizeTest, IsLostInTheDarkAndFindsItselfElsewhere) {
  MapCollector told = MakeCollector();
  const CameraRig rig = SmallRig(GetParam());
  const auto session = Localizer(GetParam(), &told);
  const std::vector<SE3> poses = GentleDrive(kMapFrames, kStep);
  int index = 0;
  const auto dark = session->Track(BlackFrame(rig, index++));
  ASSERT_TRUE(dark.ok()) << dark.status();
  EXPECT_EQ(dark->state, TrackingState::kLost);
  EXPECT_FALSE(dark->map_from_camera.has_value());
  EXPECT_EQ(dark->failure, LocalizationFailure::kNoCandidates);
  for (int i = 16; i < 20; ++i) ExpectAt(*session->Track(SeeRoom(rig, poses[i], index++)), poses[i], kBound);
  EXPECT_EQ(session->Track(BlackFrame(rig, index++))->state, TrackingState::kLost);
  for (int i = 2; i < 6; ++i) ExpectAt(*session->Track(SeeRoom(rig, poses[i], index++)), poses[i], kBound);
}

// A vehicle is told the same whether the map is in memory or read as it drives.
TEST_P(LocalizeTest, TracksAsWellInAMapThatIsReadAsItIsNeeded) {
  MapCollector told = MakeCollector();
  const CameraRig rig = SmallRig(GetParam());
  const auto whole = Localizer(GetParam(), &told);
  const auto parts = LocalizerWithoutMemory(GetParam(), &told);
  const std::vector<SE3> poses = GentleDrive(kMapFrames, kStep);
  for (int i = 0; i < kMapFrames; ++i) {
    const FrameInput frame = i == 9 ? BlackFrame(rig, i) : SeeRoom(rig, Beside(poses[i]), i);
    const auto expected = whole->Track(frame);
    const auto result = parts->Track(frame);
    ASSERT_TRUE(expected.ok() && result.ok()) << result.status();
    ASSERT_EQ(result->state, expected->state) << i;
    EXPECT_EQ(result->inliers, expected->inliers) << i;
    EXPECT_EQ(result->map_version, 5U);
    if (!expected->map_from_camera) continue;
    const SE3 difference = result->map_from_camera->Inverse() * *expected->map_from_camera;
    EXPECT_LT(difference.translation().norm(), 1e-9) << i;
    EXPECT_LT(difference.RotationAngle(), 1e-9) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, LocalizeTest, ::testing::Values(SensorType::kMono, SensorType::kStereo));

TEST_F(StoredMapTest, ExtendingGoesOnBeyondTheMapsEnd) {
  MapCollector told = MakeCollector();
  const CameraRig rig = SmallRig(SensorType::kStereo);
  const KeyFrameId last_keyframe = made_->last_keyframe();
  const MapPointId last_point = made_->last_point();
  const size_t keyframes_before = made_->keyframes().size();
  const auto session = Extender(&told);
  const std::vector<SE3> poses = GentleDrive(kMapFrames + 16, kStep);
  int index = 0;
  EXPECT_EQ(session->Track(BlackFrame(rig, index++))->state, TrackingState::kLost);
  EXPECT_TRUE(told.deltas().empty()) << "before it found itself there is nothing to say";
  // The frame that is found was answered already, in a frame of its own; the next one is tracked in the map.
  EXPECT_TRUE(session->Track(SeeRoom(rig, poses[10], index++))->in_own_piece);
  for (size_t i = 11; i < poses.size(); ++i)
    ExpectAt(*session->Track(SeeRoom(rig, poses[i], index++)), poses[i], kBound);
  session->Finish();

  EXPECT_GT(session->Stats().keyframes, static_cast<int>(keyframes_before));
  bool uses_old_points = false;
  for (const MapDelta& delta : told.deltas()) {
    EXPECT_FALSE(delta.reset);
    for (const KeyFrameRecord& keyframe : delta.added_keyframes) EXPECT_GT(keyframe.id, last_keyframe);
    for (const KeyFrameObservations& seen : delta.observations) {
      if (seen.id <= last_keyframe) continue;
      for (const MapPointId point : seen.point_of_keypoint)
        uses_old_points = uses_old_points || (point.IsValid() && point <= last_point);
    }
  }
  EXPECT_TRUE(uses_old_points) << "new keyframes hang on the old map";
}

// What was stored, and after it what the extension told, is one sound map.
TEST_F(StoredMapTest, StoredMapAndExtensionAreOneMap) {
  MapCollector all = *made_;
  const CameraRig rig = SmallRig(SensorType::kStereo);
  const auto session = Extender(&all);
  const std::vector<SE3> poses = GentleDrive(kMapFrames + 16, kStep);
  for (size_t i = 8; i < poses.size(); ++i)
    ASSERT_TRUE(session->Track(SeeRoom(rig, Beside(poses[i]), static_cast<int>(i))).ok());
  session->Finish();
  const auto whole = all.Restore();
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_EQ(static_cast<int>(whole->keyframes().size()), session->Stats().keyframes);
  EXPECT_EQ(static_cast<int>(whole->points().size()), session->Stats().points);
  EXPECT_GT(whole->keyframes().size(), made_->keyframes().size());
}

}  // namespace
}  // namespace semmap
