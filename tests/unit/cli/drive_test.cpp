// The parts of `semmap drive` without a server: playing a source into a drive, following it, reporting.

#include <thread>

#include <gmock/gmock.h>

#include "client/cli/drive_report.h"
#include "client/cli/drive_runner.h"
#include "client/cli/frame_message.h"
#include "client/cli/rig_conversion.h"
#include "tests/unit/cli/cli_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

// `count` tiny raw frames, 50 ms apart; fails at frame `fail_at`.
class FakeSource : public FrameSource {
 public:
  explicit FakeSource(uint64_t count, uint64_t fail_at = UINT64_MAX) : count_(count), fail_at_(fail_at) {}

  const CameraRig& rig() const override { return rig_; }
  std::optional<size_t> frame_count() const override { return count_; }
  const std::optional<Trajectory>& ground_truth() const override { return ground_truth_; }
  absl::StatusOr<std::optional<SourceFrame>> Next() override {
    if (next_ == fail_at_) return absl::NotFoundError("frame is gone");
    if (next_ == count_) return std::nullopt;
    SourceFrame frame;
    frame.sequence = next_;
    frame.timestamp = static_cast<TimestampNs>(next_) * 50'000'000;
    frame.image.pixels = cv::Mat(4, 4, CV_8UC1, cv::Scalar(7));
    ++next_;
    return frame;
  }

 private:
  CameraRig rig_;
  std::optional<Trajectory> ground_truth_;
  uint64_t count_;
  uint64_t fail_at_;
  uint64_t next_ = 0;
};

// Answers each frame at once; frame `lost` without a pose.
class FakeDrive : public Drive {
 public:
  explicit FakeDrive(DriveObserver observer, uint64_t lost = 0)
      : observer_(std::move(observer)), lost_(lost) {}

  const v1::SessionStarted& started() const override { return started_; }
  absl::Status Send(v1::Frame frame) override {
    if (!send_status.ok()) return send_status;
    sequences.push_back(frame.sequence());
    v1::FrameEstimate estimate;
    estimate.set_sequence(frame.sequence());
    estimate.set_timestamp_ns(frame.timestamp_ns());
    estimate.set_state(frame.sequence() == lost_ ? v1::TRACKING_STATE_LOST : v1::TRACKING_STATE_TRACKING);
    if (frame.sequence() != lost_) {
      estimate.mutable_map_from_camera()->mutable_translation()->set_x(static_cast<double>(frame.sequence()));
      estimate.mutable_map_from_camera()->mutable_rotation()->set_w(1);
    }
    estimate.mutable_times()->set_track_ms(3);
    observer_.on_estimate(estimate);
    return absl::OkStatus();
  }
  bool HasCredit() const override { return true; }
  absl::Status WaitForAnswers(std::chrono::milliseconds) override {
    ++waits;
    return absl::OkStatus();
  }
  absl::StatusOr<v1::SessionSummary> Finish() override {
    finished = true;
    v1::SessionSummary summary;
    summary.mutable_session()->set_map("maps/town");
    summary.mutable_session()->set_name("sessions/7f");
    summary.mutable_session()->mutable_statistics()->set_frames_tracked(sequences.size() -
                                                                        (lost_ > 0 ? 1 : 0));
    return summary;
  }
  void CutStream() override {}

  std::vector<uint64_t> sequences;
  int waits = 0;
  bool finished = false;
  absl::Status send_status;

 private:
  v1::SessionStarted started_;
  DriveObserver observer_;
  uint64_t lost_;
};

class PlayTest : public ::testing::Test {
 protected:
  absl::StatusOr<PlayResult> PlayAll(FakeSource source, FakeDrive& drive, const PlayOptions& options) {
    return Play(source, drive, monitor_, options, Console{out_, err_, false});
  }

  std::ostringstream out_;
  std::ostringstream err_;
  DriveMonitor monitor_;
};

TEST_F(PlayTest, SendsEveryFrameFromOneOnAndWaitsForEachAnswer) {
  FakeDrive drive(monitor_.Observer());
  const auto result = PlayAll(FakeSource(3), drive, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(drive.sequences, (std::vector<uint64_t>{1, 2, 3}));
  EXPECT_EQ(drive.waits, 4);
  EXPECT_EQ(result->frames, 3U);
  EXPECT_EQ(result->last_sequence, 3U);
  EXPECT_TRUE(out_.str().empty());
  EXPECT_THAT(err_.str(), HasSubstr("3/3"));
}

TEST_F(PlayTest, RealtimeKeepsTheRecordedPace) {
  FakeDrive drive(monitor_.Observer());
  PlayOptions options;
  options.pace = Pace::kRealtime;
  const auto result = PlayAll(FakeSource(5), drive, options);
  ASSERT_TRUE(result.ok());
  EXPECT_GE(result->duration_s, 0.195);
  EXPECT_EQ(drive.waits, 1);
}

TEST_F(PlayTest, StopsAfterTheFramesAskedFor) {
  FakeDrive drive(monitor_.Observer());
  PlayOptions options;
  options.max_frames = 2;
  EXPECT_EQ(PlayAll(FakeSource(5), drive, options)->frames, 2U);
}

TEST_F(PlayTest, EndsTheSessionWhenTheSourceFails) {
  FakeDrive drive(monitor_.Observer());
  const auto result = PlayAll(FakeSource(5, 2), drive, {});
  EXPECT_EQ(result.status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(drive.finished);
}

TEST_F(PlayTest, PassesOnTheServersRefusal) {
  FakeDrive drive(monitor_.Observer());
  drive.send_status = absl::InvalidArgumentError("IMAGE_CORRUPT");
  EXPECT_EQ(PlayAll(FakeSource(5), drive, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(PlayTest, TheMonitorCollectsPosesAndLatencies) {
  FakeDrive drive(monitor_.Observer(), 2);
  const auto result = PlayAll(FakeSource(4), drive, {});
  ASSERT_TRUE(result.ok());
  const SequencedPoses poses = monitor_.online_poses();
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_DOUBLE_EQ(poses.at(3).map_from_camera.translation().x(), 3.0);
  EXPECT_EQ(poses.at(3).timestamp, 100'000'000);
  EXPECT_EQ(monitor_.latencies().answer_ms.size(), 4U);
  EXPECT_EQ(monitor_.latencies().track_ms, (std::vector<double>{3, 3, 3, 3}));
  const nlohmann::json summary = DriveJson(*result, monitor_.latencies(), "");
  for (const char* key : {"frames", "tracked", "keyframes", "points", "dropped", "median_ms", "p95_ms",
                          "duration_s", "fps", "map", "session", "trajectory"}) {
    EXPECT_TRUE(summary.contains(key)) << key;
  }
  EXPECT_EQ(summary["tracked"], 3);
  EXPECT_EQ(summary["map"], "town");
  EXPECT_TRUE(summary["trajectory"].is_null());
  EXPECT_THAT(DriveTable(summary), HasSubstr("town"));
}

TEST_F(PlayTest, DroppedFramesCountAsAnswered) {
  DriveObserver observer = monitor_.Observer();
  monitor_.NoteSent(1);
  monitor_.NoteSent(2);
  v1::FramesDropped dropped;
  dropped.add_sequences(1);
  observer.on_dropped(dropped);
  EXPECT_EQ(monitor_.Progress().answered, 1U);
  EXPECT_EQ(monitor_.Progress().sent, 2U);
}

TEST(WithoutHoles, RepeatsTheLastKnownPose) {
  SequencedPoses poses;
  poses[2] = {200, SE3(Eigen::Quaterniond::Identity(), {2, 0, 0})};
  poses[4] = {400, SE3(Eigen::Quaterniond::Identity(), {4, 0, 0})};
  uint64_t filled = 0;
  const Trajectory trajectory = WithoutHoles(poses, 1, 5, &filled);
  ASSERT_EQ(trajectory.size(), 5U);
  EXPECT_EQ(filled, 3U);
  const std::vector<double> expected = {0, 2, 2, 4, 4};
  for (size_t i = 0; i < 5; ++i)
    EXPECT_EQ(trajectory.poses[i].map_from_camera.translation().x(), expected[i]);
  EXPECT_EQ(WithHoles(poses).size(), 2U);
}

TEST(FrameMessage, SendsFilesAsTheyAreAndPixelsRaw) {
  SourceFrame frame;
  frame.sequence = 4;
  frame.timestamp = 99;
  frame.image.encoding = ImageEncoding::kPng;
  frame.image.encoded = "\x89PNG\r\n\x1A\nrest";
  frame.depth.pixels = cv::Mat(2, 3, CV_16UC1, cv::Scalar(500));
  const auto message = FrameMessage(frame);
  ASSERT_TRUE(message.ok()) << message.status();
  EXPECT_EQ(message->sequence(), 5U);
  EXPECT_EQ(message->timestamp_ns(), 99);
  EXPECT_EQ(message->image().encoding(), v1::IMAGE_ENCODING_PNG);
  EXPECT_EQ(message->image().data(), frame.image.encoded);
  EXPECT_FALSE(message->has_right());
  EXPECT_EQ(message->depth().encoding(), v1::IMAGE_ENCODING_RAW_DEPTH16);
  EXPECT_EQ(message->depth().data().size(), 12U);
}

TEST(FrameMessage, SendsMaskAndWheelSpeedWhereThereAre) {
  SourceFrame frame;
  frame.image.pixels = cv::Mat(2, 3, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_FALSE(FrameMessage(frame)->has_class_mask());
  EXPECT_FALSE(FrameMessage(frame)->has_odometry());
  frame.class_mask.pixels = cv::Mat(2, 3, CV_8UC1, cv::Scalar(7));
  frame.wheel_speed_m_s = 8.5;
  const auto message = FrameMessage(frame);
  ASSERT_TRUE(message.ok()) << message.status();
  EXPECT_EQ(message->image().encoding(), v1::IMAGE_ENCODING_RAW_BGR8);
  EXPECT_EQ(message->class_mask().encoding(), v1::IMAGE_ENCODING_RAW_GRAY8);
  EXPECT_EQ(message->class_mask().data(), std::string(6, '\7'));
  EXPECT_EQ(message->odometry().speed_m_s(), 8.5);
}

TEST(DriveReport, TellsTheErrorWhereTheTruthIsKnown) {
  PlayResult result;
  result.frames = 4;
  result.summary.mutable_session()->mutable_statistics()->set_frames_tracked(3);
  nlohmann::json summary = DriveJson(result, {}, "");
  EXPECT_DOUBLE_EQ(summary["tracked_share"].get<double>(), 0.75);
  EXPECT_FALSE(summary.contains("ate_rmse_m"));
  EXPECT_THAT(DriveTable(summary), ::testing::Not(HasSubstr("RMSE")));
  AteResult ate;
  ate.translation_m.rmse = 0.25;
  ate.translation_m.max = 0.5;
  ate.errors_m = {0.1, 0.2, 0.5};
  AddTruth(ate, SensorType::kMono, &summary);
  EXPECT_EQ(summary["ate_rmse_m"], 0.25);
  EXPECT_EQ(summary["ate_max_m"], 0.5);
  EXPECT_EQ(summary["ate_poses"], 3);
  EXPECT_EQ(summary["ate_alignment"], "sim3");
  EXPECT_THAT(DriveTable(summary), HasSubstr("0.2500 m RMSE"));
  AddTruth(ate, SensorType::kStereo, &summary);
  EXPECT_EQ(summary["ate_alignment"], "se3");
}

TEST(RigConversion, KeepsEveryNumber) {
  CameraRig rig;
  rig.sensor = SensorType::kRgbd;
  rig.camera = {640, 480, 500, 501, 320, 240, DistortionModel::kRadialTangential, {1, 2, 3, 4, 5}};
  rig.baseline_m = 0.08;
  rig.depth_units_per_metre = 5000;
  rig.frames_per_second = 30;
  rig.body_from_camera = SE3(Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, 2, 3});
  const v1::CameraRig message = ToProto(rig);
  EXPECT_EQ(message.sensor(), v1::SENSOR_TYPE_RGBD);
  EXPECT_EQ(message.camera().width(), 640);
  EXPECT_EQ(message.camera().fy(), 501);
  EXPECT_EQ(message.camera().distortion_size(), 5);
  EXPECT_EQ(message.camera().distortion(4), 5);
  EXPECT_EQ(message.baseline_m(), 0.08);
  EXPECT_EQ(message.depth_units_per_metre(), 5000);
  EXPECT_EQ(message.frames_per_second(), 30);
  EXPECT_LT((FromProto(message.body_from_camera()).Inverse() * rig.body_from_camera).Log().norm(), 1e-12);
  rig.camera.distortion_model = DistortionModel::kEquidistant;
  EXPECT_EQ(ToProto(rig).camera().distortion_size(), 4);
  rig.camera.distortion_model = DistortionModel::kNone;
  EXPECT_EQ(ToProto(rig).camera().distortion_size(), 0);
}

TEST(DriveCommand, SaysWhenThereIsNoServer) {
  const std::string folder = SharedDataFolder() + "/sequences/kitti06_stereo51";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no shared sequence at " << folder;
  const Outcome outcome =
      RunProgram({"drive", "--server", "localhost:1", "--timeout", "0.5", "--source", "kitti:" + folder,
                  "--sensor", "stereo", "--mode", "map", "--map", "m", "--vehicle", "v", "--json"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(outcome.out.empty());
  EXPECT_FALSE(outcome.err.empty());
}

}  // namespace
}  // namespace semmap::client
