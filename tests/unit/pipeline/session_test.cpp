#include "slam/pipeline/session.h"

#include <gtest/gtest.h>

#include "slam/evaluation/ate.h"
#include "slam/evaluation/trajectory_collector.h"
#include "tests/support/room_drive.h"
#include "tests/support/textured_room.h"

namespace semmap {
namespace {

using ::semmap::testing::DriveThroughRoom;
using ::semmap::testing::GentleDrive;
using ::semmap::testing::SmallRig;

constexpr int kFrames = 24;
constexpr double kStep = 0.12;

// Frames are drawn once for all tests of a sensor.
const std::vector<FrameInput>& Drive(SensorType sensor) {
  static std::map<SensorType, std::vector<FrameInput>> drives;
  std::vector<FrameInput>& frames = drives[sensor];
  if (frames.empty()) frames = DriveThroughRoom(sensor, kFrames, kStep);
  return frames;
}

struct DriveResult {
  int tracked = 0;
  Trajectory trajectory;
  SessionStats stats;
};

SlamConfig SmallConfig(bool deterministic) {
  SlamConfig config;
  config.orb.features = 800;
  config.deterministic = deterministic;
  return config;
}

DriveResult RunDrive(SensorType sensor, bool deterministic, Executor* executor) {
  TrajectoryCollector collector;
  auto session = Session::Create(SmallConfig(deterministic), SmallRig(sensor), &collector, executor);
  EXPECT_TRUE(session.ok()) << session.status();
  DriveResult result;
  for (const FrameInput& frame : Drive(sensor)) {
    (*session)->WaitForMapper(1);
    const auto answer = (*session)->Track(frame);
    EXPECT_TRUE(answer.ok()) << answer.status();
    if (answer.ok() && answer->state == TrackingState::kTracking) ++result.tracked;
  }
  (*session)->Finish();
  result.trajectory = collector.Compose();
  result.stats = (*session)->Stats();
  return result;
}

double Error(const Trajectory& estimate, Alignment alignment) {
  Trajectory truth;
  const std::vector<SE3> poses = GentleDrive(kFrames, kStep);
  for (int i = 0; i < kFrames; ++i) truth.poses.push_back({FromSeconds(0.1 * i), poses[i]});
  const auto pairs = AssociateByTime(truth, estimate);
  if (!pairs.ok()) return 1e9;
  const auto ate = ComputeAte(*pairs, alignment);
  return ate.ok() ? ate->translation_m.rmse : 1e9;
}

TEST(SessionTest, StereoTracksEveryFrame) {
  const DriveResult result = RunDrive(SensorType::kStereo, true, nullptr);
  EXPECT_EQ(result.tracked, kFrames);
  EXPECT_EQ(result.trajectory.size(), static_cast<size_t>(kFrames));
  EXPECT_LT(Error(result.trajectory, Alignment::kSe3), 0.02);
  EXPECT_GT(result.stats.keyframes, 1);
}

TEST(SessionTest, DepthTracksEveryFrame) {
  const DriveResult result = RunDrive(SensorType::kRgbd, true, nullptr);
  EXPECT_EQ(result.tracked, kFrames);
  EXPECT_LT(Error(result.trajectory, Alignment::kSe3), 0.02);
}

TEST(SessionTest, MonocularFindsShapeOfTheDrive) {
  const DriveResult result = RunDrive(SensorType::kMono, true, nullptr);
  EXPECT_GE(result.tracked, kFrames - 6);
  EXPECT_LT(Error(result.trajectory, Alignment::kSim3), 0.03);
}

TEST(SessionTest, MapperInTheBackgroundIsAsGood) {
  const auto pool = MakeThreadPool(1);
  const DriveResult result = RunDrive(SensorType::kStereo, false, pool.get());
  EXPECT_EQ(result.tracked, kFrames);
  EXPECT_LT(Error(result.trajectory, Alignment::kSe3), 0.02);
}

TEST(SessionTest, SameInputGivesSameBytes) {
  const Trajectory first = RunDrive(SensorType::kMono, true, nullptr).trajectory;
  const Trajectory second = RunDrive(SensorType::kMono, true, nullptr).trajectory;
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first.poses[i].map_from_camera.translation(), second.poses[i].map_from_camera.translation());
    EXPECT_EQ(first.poses[i].map_from_camera.rotation().coeffs(),
              second.poses[i].map_from_camera.rotation().coeffs());
  }
}

class BadInputTest : public ::testing::Test {
 protected:
  BadInputTest()
      : session_(*Session::Create(SmallConfig(true), SmallRig(SensorType::kStereo), &collector_, nullptr)) {}

  void ExpectRefused(const FrameInput& frame, const char* reason) {
    const auto answer = session_->Track(frame);
    ASSERT_FALSE(answer.ok());
    EXPECT_EQ(answer.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(answer.status().message().find(reason), std::string::npos) << answer.status();
  }

  TrajectoryCollector collector_;
  std::unique_ptr<Session> session_;
};

TEST_F(BadInputTest, WrongImagesAreRefusedAndTheDriveGoesOn) {
  const std::vector<FrameInput>& frames = Drive(SensorType::kStereo);
  ASSERT_TRUE(session_->Track(frames[0]).ok());
  FrameInput bad = frames[1];
  bad.right = cv::Mat();
  ExpectRefused(bad, "right image");
  bad = frames[1];
  bad.image = bad.image.colRange(0, 100);
  ExpectRefused(bad, "image is 100x320");
  bad = frames[1];
  bad.image = cv::Mat(bad.image.size(), CV_8UC3);
  ExpectRefused(bad, "pixel type");
  const auto good = session_->Track(frames[1]);
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(good->state, TrackingState::kTracking);
}

TEST_F(BadInputTest, TimeAndSequenceMustGrow) {
  const std::vector<FrameInput>& frames = Drive(SensorType::kStereo);
  ASSERT_TRUE(session_->Track(frames[1]).ok());
  ExpectRefused(frames[0], "sequence");
  FrameInput late = frames[2];
  late.timestamp = frames[1].timestamp;
  ExpectRefused(late, "timestamp");
}

TEST_F(BadInputTest, BlackFramesLoseTheTrackAndThePlaceBringsItBack) {
  const std::vector<FrameInput>& frames = Drive(SensorType::kStereo);
  for (int i = 0; i < 16; ++i) ASSERT_TRUE(session_->Track(frames[i]).ok());
  FrameInput black = frames[16];
  black.image = cv::Mat::zeros(black.image.size(), CV_8UC1);
  black.right = black.image;
  const auto lost = session_->Track(black);
  ASSERT_TRUE(lost.ok());
  EXPECT_NE(lost->state, TrackingState::kTracking);
  EXPECT_FALSE(lost->map_from_camera.has_value());
  const auto found = session_->Track(frames[17]);
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->state, TrackingState::kTracking);
}

TEST_F(BadInputTest, AVehicleCarriedBackKnowsWhereItIs) {
  const std::vector<FrameInput>& frames = Drive(SensorType::kStereo);
  const std::vector<SE3> truth = GentleDrive(kFrames, kStep);
  SE3 map_from_camera;
  for (int i = 0; i < 22; ++i) map_from_camera = *session_->Track(frames[i])->map_from_camera;
  FrameInput carried = frames[4];
  carried.sequence = frames[22].sequence;
  carried.timestamp = frames[22].timestamp;
  const auto found = session_->Track(carried);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->state, TrackingState::kTracking);
  const SE3 expected = map_from_camera * truth[21].Inverse() * truth[4];
  EXPECT_LT((expected.Inverse() * *found->map_from_camera).translation().norm(), 0.05);
}

TEST(SessionCreateTest, UnusableRigIsRefused) {
  TrajectoryCollector collector;
  CameraRig rig = SmallRig(SensorType::kStereo);
  rig.baseline_m = 0;
  EXPECT_EQ(Session::Create(SmallConfig(true), rig, &collector, nullptr).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(Session::Create(SmallConfig(false), SmallRig(SensorType::kMono), &collector, nullptr).ok());
}

}  // namespace
}  // namespace semmap
