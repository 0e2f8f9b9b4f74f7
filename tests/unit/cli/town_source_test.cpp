// A vehicle of the simulated town as a source of frames, and how `semmap town drive` asks where to.

#include "client/cli/town_source.h"

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/unit/cli/cli_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

town::DriveConfig SmallDrive() {
  town::DriveConfig config;
  config.rig.width = 320;
  config.rig.height = 240;
  config.traffic = {0, 0};
  config.stereo = true;
  config.max_frames = 3;
  return config;
}

#define SKIP_WITHOUT_EGL(result)                                                  \
  if (absl::IsUnavailable((result).status())) {                                   \
    GTEST_SKIP() << "no off-screen OpenGL here: " << (result).status().message(); \
  }                                                                               \
  ASSERT_TRUE((result).ok()) << (result).status()

TEST(TownSource, GivesWhatTheDriveSees) {
  TownSourceOptions options;
  options.class_mask = true;
  auto source = TownSource::Create(SmallDrive(), options);
  SKIP_WITHOUT_EGL(source);
  auto drive = town::TownDrive::Create(SmallDrive());
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_TRUE(ValidateRig((*source)->rig()).ok());
  EXPECT_EQ((*source)->rig().sensor, SensorType::kStereo);
  EXPECT_EQ((*source)->frame_count(), 3U);
  town::DriveFrame truth;
  for (uint64_t i = 0; i < 3; ++i) {
    const auto frame = (*source)->Next();
    ASSERT_TRUE(frame.ok() && frame->has_value());
    ASSERT_TRUE(*(*drive)->Next(&truth));
    EXPECT_EQ((*frame)->sequence, i);
    EXPECT_EQ((*frame)->timestamp, truth.timestamp_ns);
    cv::Mat rgb;
    cv::cvtColor((*frame)->image.pixels, rgb, cv::COLOR_BGR2RGB);
    EXPECT_EQ(cv::norm(rgb, truth.left.rgb, cv::NORM_INF), 0);
    cv::cvtColor((*frame)->right.pixels, rgb, cv::COLOR_BGR2RGB);
    EXPECT_EQ(cv::norm(rgb, truth.right_rgb, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm((*frame)->class_mask.pixels, truth.left.mask, cv::NORM_INF), 0);
    EXPECT_EQ((*frame)->wheel_speed_m_s, truth.wheel_speed);
  }
  EXPECT_FALSE((*source)->Next()->has_value());
  ASSERT_TRUE((*source)->ground_truth().has_value());
  const Trajectory& poses = *(*source)->ground_truth();
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_LT(poses.poses[0].map_from_camera.Log().norm(), 1e-9);
  EXPECT_EQ(poses.poses[2].timestamp, truth.timestamp_ns);
}

TEST(TownSource, SendsGreyJpegWhenAskedTo) {
  town::DriveConfig config = SmallDrive();
  config.stereo = false;
  TownSourceOptions options;
  options.grey = true;
  options.jpeg_quality = 80;
  auto source = TownSource::Create(config, options);
  SKIP_WITHOUT_EGL(source);
  EXPECT_EQ((*source)->rig().sensor, SensorType::kMono);
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  EXPECT_EQ((*frame)->image.encoding, ImageEncoding::kJpeg);
  EXPECT_TRUE((*frame)->right.empty());
  EXPECT_TRUE((*frame)->class_mask.empty());
  const auto grey = DecodeGray((*frame)->image);
  ASSERT_TRUE(grey.ok()) << grey.status();
  EXPECT_EQ(grey->size(), cv::Size(320, 240));
}

TEST(TownDriveCommand, AsksWhereTo) {
  const Outcome outcome = RunProgram({"town", "drive", "--route", "2"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--output"));
  EXPECT_THAT(outcome.err, HasSubstr("--map"));
}

TEST(TownDriveCommand, SaysWhenThereIsNoServer) {
  const Outcome outcome = RunProgram({"town", "drive", "--server", "localhost:1", "--timeout", "0.5", "--map",
                                      "m", "--frames", "2", "--vehicles", "0", "--pedestrians", "0"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_FALSE(outcome.err.empty());
}

}  // namespace
}  // namespace semmap::client
