// Loops on a ring road: detection, verification, correction, and the adjustment of the whole map.
#include <gtest/gtest.h>

#include <map>

#include "slam/pipeline/full_bundle.h"
#include "slam/pipeline/loop_closer.h"
#include "tests/unit/pipeline/loop_test_util.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the ring and what is made of it

RingDrift DriftOf(SensorType sensor) {
  return sensor == SensorType::kMono ? RingDrift{0.002, 0.004} : RingDrift{0.004, 0};
}

class LoopTest : public ::testing::TestWithParam<SensorType> {
 protected:
  LoopTest()
      : world_(1),
        camera_(RingWorld::Camera(GetParam())),
        map_(DriveRing(world_, camera_, kRingKeyFrames, kRingStep, DriftOf(GetParam()))),
        places_(Remember(map_)) {}

  bool mono() const { return GetParam() == SensorType::kMono; }
  double Error() const { return RingError(map_, kRingStep, mono()); }

  LoopConfig config_;
  RingWorld world_;
  MappingCamera camera_;
  Map map_;
  PlaceMemory places_;
};

TEST_P(LoopTest, IsDetectedWhenThePlaceIsSeenAgain) {
  LoopDetector detector(config_);
  PlaceMemory places(RandomVocabulary(12, 5), PlaceQueryLimits());
  for (const KeyFrameId id : SortedKeyFrames(map_)) {
    places.Add(*map_.FindKeyFrame(id));
    const std::vector<KeyFrameId> detected = detector.Detect(map_, places, id);
    // Three in a row are wanted, and what is covisible is no loop.
    if (id.value() <= 2) {
      EXPECT_TRUE(detected.empty());
    }
    for (const KeyFrameId candidate : detected) {
      EXPECT_FALSE(map_.FindKeyFrame(id)->covisible.contains(candidate));
    }
    if (id.value() < 51) continue;
    ASSERT_FALSE(detected.empty()) << id.value();
    EXPECT_LE(detected.front().value(), id.value() - 48 + 3);
  }
}

TEST_P(LoopTest, VerificationMeasuresTheTruth) {
  const auto loop = VerifyLoop(config_, 1, camera_, places_, map_, KeyFrameId(2), KeyFrameId(50));
  ASSERT_TRUE(loop.has_value());
  const SE3 truth =
      RingWorld::WorldFromCamera(1 * kRingStep).Inverse() * RingWorld::WorldFromCamera(49 * kRingStep);
  const SE3 error = truth.Inverse() * loop->old_from_current.rigid;
  EXPECT_LT(error.translation().norm(), 0.08);
  EXPECT_LT(error.RotationAngle(), 0.005);
  // One unit at the end is e^(drift * 49) true metres: the old side's units are smaller.
  const double expected = mono() ? std::exp(-(50 - 2) * DriftOf(GetParam()).scale_log) : 1.0;
  EXPECT_NEAR(loop->old_from_current.scale, expected, 0.01);
  EXPECT_GE(loop->seen.size(), 50u);
}

TEST_P(LoopTest, TwoPlacesAreNoLoop) {
  EXPECT_FALSE(VerifyLoop(config_, 1, camera_, places_, map_, KeyFrameId(2), KeyFrameId(25)).has_value());
}

TEST_P(LoopTest, CorrectionClosesTheGapAndJoinsThePoints) {
  const auto loop = VerifyLoop(config_, 1, camera_, places_, map_, KeyFrameId(2), KeyFrameId(50));
  ASSERT_TRUE(loop.has_value());
  const double before = Error();
  const size_t points_before = map_.points().size();
  map_.TakeDelta();
  const LoopCorrection correction = CloseLoop(config_, camera_, *loop, &map_);
  EXPECT_GT(before, 0.3);
  EXPECT_LT(Error(), 0.35 * before);
  EXPECT_LT(map_.points().size(), points_before);
  EXPECT_GT(correction.fused_points, 100);
  EXPECT_TRUE(map_.FindKeyFrame(KeyFrameId(50))->covisible.contains(KeyFrameId(2)));
  EXPECT_EQ(map_.FindKeyFrame(KeyFrameId(2))->loops, std::vector{KeyFrameId(50)});
  // The map's frame stays.
  EXPECT_LT(map_.FindKeyFrame(KeyFrameId(1))->Center().norm(), 1e-12);
  const MapDelta delta = map_.TakeDelta();
  EXPECT_GE(delta.moved_keyframes.size(), 50u);
  std::map<KeyFrameId, double> scales;
  for (const KeyFramePose& moved : delta.moved_keyframes) scales[moved.id] = moved.rescale;
  EXPECT_DOUBLE_EQ(scales.at(KeyFrameId(50)), correction.scale);
  EXPECT_NEAR(scales.at(KeyFrameId(50)), scales.at(KeyFrameId(2)) * loop->old_from_current.scale, 1e-3);
}

TEST_P(LoopTest, FullAdjustmentRemovesWhatThePoseGraphLeft) {
  const auto loop = VerifyLoop(config_, 1, camera_, places_, map_, KeyFrameId(2), KeyFrameId(50));
  ASSERT_TRUE(loop.has_value());
  CloseLoop(config_, camera_, *loop, &map_);
  const double before = Error();
  config_.full_iterations = 30;
  FullBundle bundle(config_, camera_.model, map_);
  // The map goes on growing while the copy is adjusted.
  const RingView view = world_.View(camera_, RingWorld::WorldFromCamera(kRingKeyFrames * kRingStep), 900);
  const KeyFrame& last = *map_.FindKeyFrame(KeyFrameId(kRingKeyFrames));
  const SE3 motion = RingWorld::WorldFromCamera(kRingKeyFrames * kRingStep).Inverse() *
                     RingWorld::WorldFromCamera((kRingKeyFrames - 1) * kRingStep);
  map_.AddKeyFrame(
      MakeKeyFrame(camera_, KeyFrameId(kRingKeyFrames + 1), view, motion * last.camera_from_map));
  const MapPointId seen =
      *std::find_if(last.points.begin(), last.points.end(), [](MapPointId point) { return point.IsValid(); });
  ASSERT_TRUE(map_.AddObservation(seen, KeyFrameId(kRingKeyFrames + 1), 0));
  map_.ChooseParent(KeyFrameId(kRingKeyFrames + 1));
  const MapPointId newer = map_.AddPoint({1, 2, 3}, KeyFrameId(kRingKeyFrames + 1));
  ASSERT_TRUE(map_.AddObservation(newer, KeyFrameId(kRingKeyFrames + 1), 1));
  const Eigen::Vector3d newer_in_camera =
      map_.FindKeyFrame(KeyFrameId(kRingKeyFrames + 1))->camera_from_map * Eigen::Vector3d(1, 2, 3);
  bundle.Solve(nullptr);
  bundle.Apply(&map_);
  EXPECT_LT(Error(), 0.5 * before);
  // The newcomer came along with its parent, and its point with it.
  const KeyFrame& newcomer = *map_.FindKeyFrame(KeyFrameId(kRingKeyFrames + 1));
  const SE3 kept = newcomer.camera_from_map * map_.FindKeyFrame(newcomer.parent)->camera_from_map.Inverse();
  EXPECT_LT((kept.Inverse() * motion).translation().norm(), 1e-9);
  EXPECT_LT((newcomer.camera_from_map * map_.FindPoint(newer)->position_in_map - newer_in_camera).norm(),
            1e-9);
}

TEST_P(LoopTest, CloserDoesAllOfItAndThenRests) {
  LoopCloser closer(config_, 1, camera_);
  PlaceMemory places(RandomVocabulary(12, 5), PlaceQueryLimits());
  int closed = 0;
  const double before = Error();
  for (const KeyFrameId id : SortedKeyFrames(map_)) {
    places.Add(*map_.FindKeyFrame(id));
    if (!closer.Close(id, places, &map_)) continue;
    ++closed;
    EXPECT_GE(id.value(), 36u);  // from where the walls of the start come into sight
  }
  EXPECT_EQ(closed, 1);
  EXPECT_LT(Error(), before);
}

TEST_P(LoopTest, WithoutAVocabularyNothingHappens) {
  LoopCloser closer(config_, 1, camera_);
  PlaceMemory places(nullptr, PlaceQueryLimits());
  for (const KeyFrameId id : SortedKeyFrames(map_)) {
    places.Add(*map_.FindKeyFrame(id));
    EXPECT_FALSE(closer.Close(id, places, &map_).has_value());
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, LoopTest, ::testing::Values(SensorType::kMono, SensorType::kStereo));

}  // namespace
}  // namespace semmap
