// A session whose frames are segmented beside tracking, by a stand-in for the network.
#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "slam/pipeline/session.h"
#include "tests/support/fake_segmenter.h"
#include "tests/support/textured_room.h"

namespace semmap {
namespace {

using ::semmap::testing::GentleDrive;
using ::semmap::testing::SmallRig;
using ::semmap::testing::TexturedRoom;

constexpr size_t kFrames = 16;
constexpr uint8_t kBuilding = 1;
constexpr uint8_t kWall = 11;

// All that the stand-in sees in them is a building.
std::vector<FrameInput> MakeDrive() {
  const CameraRig rig = SmallRig(SensorType::kRgbd);
  const std::vector<SE3> poses = GentleDrive(static_cast<int>(kFrames), 0.15);
  const TexturedRoom room(3);
  std::vector<FrameInput> frames;
  for (size_t i = 0; i < kFrames; ++i) {
    FrameInput frame;
    frame.sequence = i + 1;
    frame.timestamp = FromSeconds(0.1 * static_cast<double>(i));
    frame.image = room.Render(rig.camera, poses[i], &frame.depth);
    frame.colour = cv::Mat(frame.image.size(), CV_8UC3, cv::Scalar(kBuilding, 0, 0));
    frames.push_back(std::move(frame));
  }
  return frames;
}

const std::vector<FrameInput>& Drive() {
  static const std::vector<FrameInput> frames = MakeDrive();
  return frames;
}

// Keeps keyframes and points as they are at the end.
class Collector : public MapDeltaSink {
 public:
  void OnDelta(MapDelta delta) override {
    for (const KeyFrameRecord& keyframe : delta.added_keyframes)
      keyframes[keyframe.sequence] = keyframe.features;
    for (const MapPointRecord& point : delta.upserted_points) points[point.id] = point;
    for (const MapPointId id : delta.removed_points) points.erase(id);
  }

  std::map<uint64_t, std::shared_ptr<const FrameFeatures>> keyframes;
  std::map<MapPointId, MapPointRecord> points;
};

class SegmentationSessionTest : public ::testing::Test {
 protected:
  SegmentationSessionTest() {
    config_.orb.features = 800;
    config_.segmentation.mode = SegmentationMode::kEveryFrame;
    config_.segmentation.max_wait_ms = 0;
    // Many keyframes.
    config_.tracking.keyframe_ratio_depth = 0.95;
  }
  ~SegmentationSessionTest() override { segmenter_->Open(); }

  void Start() {
    auto session =
        Session::Create(config_, SmallRig(SensorType::kRgbd), &collector_, executor_.get(), nullptr, queue_);
    ASSERT_TRUE(session.ok()) << session.status();
    session_ = std::move(session).value();
  }

  FrameResult Track(const FrameInput& frame) {
    session_->WaitForMapper(0);
    const auto result = session_->Track(frame);
    EXPECT_TRUE(result.ok()) << result.status();
    return result.value_or(FrameResult());
  }

  void TrackAll() {
    Start();
    for (const FrameInput& frame : Drive()) EXPECT_EQ(Track(frame).state, TrackingState::kTracking);
    session_->Finish();
    ASSERT_GE(collector_.keyframes.size(), 3U);
    ASSERT_GE(collector_.points.size(), 200U);
  }

  void ExpectAllPointsAre(uint8_t semantic_class) {
    for (const auto& [id, point] : collector_.points) EXPECT_EQ(point.semantic_class, semantic_class);
  }

  SlamConfig config_;
  std::shared_ptr<FakeSegmenter> segmenter_ = std::make_shared<FakeSegmenter>();
  std::shared_ptr<SegmentationQueue> queue_ =
      std::make_shared<SegmentationQueue>(segmenter_, SegmentationQueue::Limits());
  std::unique_ptr<Executor> executor_ = MakeThreadPool(1);
  Collector collector_;
  std::unique_ptr<Session> session_;
};

TEST_F(SegmentationSessionTest, EveryFrameGetsItsClasses) {
  TrackAll();
  ExpectAllPointsAre(kBuilding);
  EXPECT_EQ(queue_->counts().submitted, kFrames);
  EXPECT_EQ(session_->Stats().classified_frames, kFrames);
  EXPECT_EQ(session_->Stats().unclassified_frames, 0U);
}

TEST_F(SegmentationSessionTest, GreyIsSegmentedWhereThereIsNoColour) {
  Start();
  FrameInput frame = Drive().front();
  frame.colour.release();
  frame.image = frame.image.clone();
  frame.image.at<uint8_t>(0, 0) = kWall;
  EXPECT_EQ(Track(frame).classes, ClassState::kKnown);
  session_->Finish();
  ExpectAllPointsAre(kWall);
}

TEST_F(SegmentationSessionTest, TheVehiclesMaskReplacesTheModel) {
  Start();
  for (FrameInput frame : Drive()) {
    frame.class_mask = cv::Mat(frame.image.size(), CV_8UC1, cv::Scalar(kWall));
    EXPECT_EQ(Track(frame).classes, ClassState::kKnown);
  }
  session_->Finish();
  ExpectAllPointsAre(kWall);
  EXPECT_EQ(queue_->counts().submitted, 0U);
}

TEST_F(SegmentationSessionTest, NothingIsAskedWhenOff) {
  config_.segmentation.mode = SegmentationMode::kOff;
  TrackAll();
  ExpectAllPointsAre(kUnknownClass);
  EXPECT_EQ(queue_->counts().submitted, 0U);
  EXPECT_EQ(session_->Stats().classified_frames, 0U);
  EXPECT_EQ(session_->Stats().unclassified_frames, 0U);
}

TEST_F(SegmentationSessionTest, KeyFramesAloneAreEnoughForTheMap) {
  config_.segmentation.mode = SegmentationMode::kKeyFrames;
  TrackAll();
  ExpectAllPointsAre(kBuilding);
  EXPECT_EQ(queue_->counts().submitted, collector_.keyframes.size());
  EXPECT_LT(queue_->counts().submitted, kFrames);
  EXPECT_EQ(session_->Stats().classified_frames, collector_.keyframes.size());
  for (const auto& [sequence, features] : collector_.keyframes) {
    for (const Keypoint& keypoint : features->keypoints) {
      EXPECT_EQ(keypoint.semantic_class, kBuilding);
      EXPECT_EQ(keypoint.class_confidence, 255);
    }
  }
}

TEST_F(SegmentationSessionTest, KeyFramesInOneThread) {
  config_.segmentation.mode = SegmentationMode::kKeyFrames;
  config_.deterministic = true;
  TrackAll();
  ExpectAllPointsAre(kBuilding);
}

// The vehicle gets its poses however slow the network is.
TEST_F(SegmentationSessionTest, AFrameGoesOnWithoutClassesThatDoNotCome) {
  config_.segmentation.max_wait_ms = 5;
  segmenter_->Close();
  TrackAll();
  ExpectAllPointsAre(kUnknownClass);
  EXPECT_EQ(session_->Stats().classified_frames, 0U);
  EXPECT_EQ(session_->Stats().unclassified_frames, kFrames);
}

// What was tracked in a keyframe without classes is what its points are, but no evidence of it.
TEST_F(SegmentationSessionTest, ClassesAreCarriedOverByTrackedPoints) {
  Start();
  Track(Drive()[0]);
  session_->WaitForMapper(0);
  segmenter_->FailWith(absl::UnavailableError("no network today"));
  for (size_t i = 1; i < kFrames; ++i) EXPECT_NE(Track(Drive()[i]).classes, ClassState::kKnown);
  session_->Finish();
  ASSERT_GE(collector_.keyframes.size(), 3U);
  int carried = 0;
  for (const auto& [sequence, features] : collector_.keyframes) {
    if (sequence == 1) continue;
    for (const Keypoint& keypoint : features->keypoints) {
      if (keypoint.semantic_class == kUnknownClass) continue;
      EXPECT_EQ(keypoint.semantic_class, kBuilding);
      EXPECT_EQ(keypoint.class_confidence, 0);
      ++carried;
    }
  }
  EXPECT_GT(carried, 100);
  // All votes are of the one frame that was looked at.
  size_t votes = 0;
  for (const auto& [id, point] : collector_.points) {
    for (const ClassVote& vote : point.votes) votes += vote.count;
  }
  EXPECT_GT(votes, 0U);
  EXPECT_LE(votes, collector_.keyframes.at(1)->size());
}

}  // namespace
}  // namespace semmap
