// A session whose frames are segmented beside tracking, by a stand-in for the network.
#include <gtest/gtest.h>

#include <vector>

#include "slam/pipeline/session.h"
#include "tests/support/contents_collector.h"
#include "tests/support/fake_segmenter.h"
#include "tests/support/room_drive.h"
#include "tests/support/textured_room.h"

namespace semmap {
namespace {

using ::semmap::testing::ContentsCollector;
using ::semmap::testing::DriveThroughRoom;
using ::semmap::testing::SmallRig;

constexpr size_t kFrames = 16;
constexpr uint8_t kBuilding = 1;
constexpr uint8_t kWall = 11;

// All that the stand-in sees in them is a building.
std::vector<FrameInput> MakeDrive() {
  std::vector<FrameInput> frames = DriveThroughRoom(SensorType::kRgbd, static_cast<int>(kFrames), 0.15);
  for (FrameInput& frame : frames)
    frame.colour = cv::Mat(frame.image.size(), CV_8UC3, cv::Scalar(kBuilding, 0, 0));
  return frames;
}

const std::vector<FrameInput>& Drive() {
  static const std::vector<FrameInput> frames = MakeDrive();
  return frames;
}

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
  ContentsCollector collector_;
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
