#include "slam/pipeline/session_mapper.h"

#include <gtest/gtest.h>

#include "tests/unit/pipeline/loop_test_util.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: the ring and what is made of it

constexpr int kKeyFrames = 30;

// A mapper that was driven along part of the ring; the map's frame is the world's.
class SessionMapperTest : public ::testing::Test {
 protected:
  SessionMapperTest()
      : world_(1),
        camera_(RingWorld::Camera(SensorType::kStereo)),
        mapper_(SlamConfig(), camera_, RingWorld::ScaleInfo(), RandomVocabulary(12, 5),
                [this](std::shared_ptr<const LocalMapView> view) { view_ = std::move(view); }) {
    const std::atomic<bool> stop = false;
    for (int i = 0; i < kKeyFrames; ++i) {
      KeyFrameCandidate candidate;
      candidate.id = KeyFrameId(static_cast<uint64_t>(i + 1));
      candidate.sequence = candidate.id.value();
      candidate.timestamp = FromSeconds(0.1 * i);
      const TrackedFrame frame = See(RingWorld::WorldFromCamera(i * kRingStep), static_cast<uint32_t>(i));
      candidate.features = frame.features;
      candidate.grid = frame.grid;
      candidate.points.assign(frame.features->size(), MapPointId());
      candidate.camera_from_reference = RingWorld::WorldFromCamera(i * kRingStep).Inverse();
      if (i > 0) {
        candidate.reference = KeyFrameId(static_cast<uint64_t>(i));
        candidate.camera_from_reference =
            candidate.camera_from_reference * RingWorld::WorldFromCamera((i - 1) * kRingStep);
        candidate.points = Track(frame, RingWorld::WorldFromCamera(i * kRingStep).Inverse());
      }
      mapper_.AddKeyFrame(candidate, &stop, &vehicle_);
    }
  }

  TrackedFrame See(const SE3& world_from_camera, uint32_t noise_seed) const {
    const RingView view = world_.View(camera_, world_from_camera, noise_seed);
    TrackedFrame frame;
    frame.sequence = 1000 + noise_seed;
    frame.features = std::make_shared<FrameFeatures>(view.features);
    frame.grid = std::make_shared<FeatureGrid>(camera_.bounds, view.features.keypoints);
    return frame;
  }

  // What a tracker that knows its pose matches.
  std::vector<MapPointId> Track(const TrackedFrame& frame, const SE3& camera_from_map) const {
    const ScalePyramidInfo scale_info = RingWorld::ScaleInfo();
    ProjectionSearch search;
    search.model = camera_.model;
    search.bounds = camera_.bounds;
    search.scale_info = &scale_info;
    SightingCounters counters;
    counters.visible.assign(view_->size(), 0);
    ViewMatches matches(frame.features->size(), -1);
    MatchLocalMap(*view_, camera_from_map, {*frame.features, *frame.grid}, search, &counters, &matches);
    std::vector<MapPointId> points;
    for (const int32_t match : matches) points.push_back(match < 0 ? MapPointId() : view_->ids[match]);
    return points;
  }

  RingWorld world_;
  MappingCamera camera_;
  std::shared_ptr<const LocalMapView> view_;
  SessionMapper mapper_;
  VehicleMapping vehicle_ = mapper_.StartVehicle(false);
};

TEST_F(SessionMapperTest, ALostFrameIsFoundFarFromTheNewestKeyFrameAndTheViewMovesThere) {
  ASSERT_EQ(view_->reference().id, KeyFrameId(kKeyFrames));
  const uint64_t version = mapper_.view_version();
  const SE3 aside(ExpSO3({0, 0.05, 0}), {0.3, 0, 0.4});
  const SE3 world_from_camera = RingWorld::WorldFromCamera(4 * kRingStep) * aside;
  const auto report = mapper_.Recover({See(world_from_camera, 500), {}}, &vehicle_);
  ASSERT_NE(report.recovery, nullptr) << static_cast<int>(report.failure);
  const SE3 error = report.recovery->frame.camera_from_map * world_from_camera;
  EXPECT_LT(error.translation().norm(), 0.1);
  EXPECT_LT(error.RotationAngle(), 0.01);
  EXPECT_LE(report.recovery->reference.value(), 10u);
  EXPECT_EQ(view_->reference().id, report.recovery->reference);
  EXPECT_GT(mapper_.view_version(), version);
  // The points that it sees are those of the view, for the tracker to go on with.
  int known = 0;
  for (const MapPointId point : report.recovery->points) {
    if (point.IsValid()) known += view_->IndexOf(point) >= 0 ? 1 : 0;
  }
  EXPECT_GE(known, 50);
}

TEST_F(SessionMapperTest, DoubtIsRefutedWhenNoOtherPlaceIsBetter) {
  const SE3 world_from_camera = RingWorld::WorldFromCamera(4 * kRingStep);
  const auto report =
      mapper_.Recover({See(world_from_camera, 500), {.expected = 100, .inliers = 90}}, &vehicle_);
  EXPECT_EQ(report.recovery, nullptr);
  EXPECT_EQ(report.failure, LocalizationFailure::kTooFewInliers);
  EXPECT_EQ(view_->reference().id, KeyFrameId(kKeyFrames));
}

TEST_F(SessionMapperTest, DoubtIsRightWhenFarMoreAgreesElsewhere) {
  const SE3 world_from_camera = RingWorld::WorldFromCamera(4 * kRingStep);
  // Many agree with the doubted pose, but most of what should be in sight, or of what is near, does not.
  EXPECT_NE(
      mapper_.Recover({See(world_from_camera, 500), {.expected = 5000, .inliers = 600}}, &vehicle_).recovery,
      nullptr);
  const Agreement far_only{.expected = 500, .inliers = 400, .near_expected = 100, .near_inliers = 3};
  EXPECT_NE(mapper_.Recover({See(world_from_camera, 501), far_only}, &vehicle_).recovery, nullptr);
}

TEST_F(SessionMapperTest, AForgottenMapFindsNothing) {
  mapper_.Reset(&vehicle_);
  EXPECT_EQ(view_, nullptr);
  const auto report = mapper_.Recover({See(RingWorld::WorldFromCamera(0), 500), {}}, &vehicle_);
  EXPECT_EQ(report.failure, LocalizationFailure::kNoCandidates);
}

}  // namespace
}  // namespace semmap
