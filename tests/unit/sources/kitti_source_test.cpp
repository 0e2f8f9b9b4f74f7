#include <gmock/gmock.h>

#include "tests/unit/sources/source_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

constexpr char kCalibration[] =
    "P0: 50 0 32 0 0 50 24 0 0 0 1 0\n"
    "P1: 50 0 32 -25 0 50 24 0 0 0 1 0\n"
    "P2: 50 0 32 3 0 50 24 0 0 0 1 0\n"
    "P3: 50 0 32 -22 0 50 24 0 0 0 1 0\n"
    "Tr: 1 2 3\n";

class KittiSource : public SourceTest {
 protected:
  void MakeRecording(const std::string& left, const std::string& right) {
    WriteText("calib.txt", kCalibration);
    WriteText("times.txt", "0.0e+00\n1.0e-01\n2.0e-01\n");
    WriteText("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n1 0 0 0 0 1 0 0 0 0 1 2\n");
    for (int i = 0; i < 3; ++i) {
      WriteGray(left + "/00000" + std::to_string(i) + ".png", 10 + i);
      WriteGray(right + "/00000" + std::to_string(i) + ".png", 20 + i);
    }
  }
  absl::StatusOr<std::unique_ptr<FrameSource>> Open(SensorType sensor) {
    return OpenSource("kitti:" + root_.string(), ForSensor(sensor));
  }
};

TEST_F(KittiSource, PlaysStereoPairsInOrder) {
  MakeRecording("image_0", "image_1");
  const auto source = Open(SensorType::kStereo);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_NEAR((*source)->rig().baseline_m, 0.5, 1e-12);
  EXPECT_NEAR((*source)->rig().frames_per_second, 10.0, 1e-6);
  EXPECT_EQ((*source)->rig().camera.width, 64);
  EXPECT_EQ((*source)->frame_count(), 3U);
  ASSERT_TRUE((*source)->ground_truth().has_value());
  EXPECT_EQ((*source)->ground_truth()->poses[2].timestamp, 200'000'000);
  for (uint64_t i = 0; i < 3; ++i) {
    const auto frame = (*source)->Next();
    ASSERT_TRUE(frame.ok() && frame->has_value());
    EXPECT_EQ((*frame)->sequence, i);
    EXPECT_EQ((*frame)->timestamp, static_cast<TimestampNs>(i) * 100'000'000);
    EXPECT_EQ(LevelOf((*frame)->image), 10 + static_cast<int>(i));
    EXPECT_EQ(LevelOf((*frame)->right), 20 + static_cast<int>(i));
  }
  EXPECT_FALSE((*source)->Next()->has_value());
}

TEST_F(KittiSource, BringsClassMasksWhenAskedTo) {
  MakeRecording("image_0", "image_1");
  for (int i = 0; i < 3; ++i) WriteGray("class/00000" + std::to_string(i) + ".png", 7 + i);
  EXPECT_TRUE((*(*Open(SensorType::kMono))->Next())->class_mask.empty());
  SourceOptions options = ForSensor(SensorType::kMono);
  options.class_masks = true;
  const auto source = OpenSource("kitti:" + root_.string(), options);
  ASSERT_TRUE(source.ok()) << source.status();
  (*source)->Next().IgnoreError();
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  const auto classes = DecodeClasses((*frame)->class_mask);
  ASSERT_TRUE(classes.ok()) << classes.status();
  EXPECT_EQ(classes->at<uint8_t>(3, 5), 8);
  std::filesystem::remove(root_ / "class" / "000002.png");
  EXPECT_EQ(OpenSource("kitti:" + root_.string(), options).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(KittiSource, MonoHasNoRightImage) {
  MakeRecording("image_0", "image_1");
  const auto frame = (*Open(SensorType::kMono))->Next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  EXPECT_TRUE((*frame)->right.empty());
}

TEST_F(KittiSource, FallsBackToTheColourCamerasAndMovesTheTruthThere) {
  MakeRecording("image_2", "image_3");
  const auto source = Open(SensorType::kStereo);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_NEAR((*source)->rig().baseline_m, 0.5, 1e-12);
  // P2's last column is 3: camera 2 lies 3 / 50 m to the left of camera 0.
  EXPECT_NEAR((*source)->ground_truth()->poses[0].map_from_camera.translation().x(), -0.06, 1e-12);
}

TEST_F(KittiSource, SaysWhatIsMissing) {
  EXPECT_EQ(Open(SensorType::kMono).status().code(), absl::StatusCode::kNotFound);
  MakeRecording("image_0", "image_1");
  EXPECT_EQ(Open(SensorType::kRgbd).status().code(), absl::StatusCode::kInvalidArgument);
  std::filesystem::remove(Path("image_1/000001.png"));
  EXPECT_EQ(Open(SensorType::kStereo).status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(Open(SensorType::kMono).ok());
  WriteText("calib.txt", "P0: 1 2 3\n");
  EXPECT_THAT(std::string(Open(SensorType::kMono).status().message()), HasSubstr("calib.txt:1: P0: needs"));
  WriteText("calib.txt", "P7: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THAT(std::string(Open(SensorType::kMono).status().message()), HasSubstr("has no line P0:"));
  WriteText("times.txt", "0\n");
  EXPECT_THAT(std::string(Open(SensorType::kMono).status().message()), HasSubstr("1 lines for 3 images"));
}

TEST_F(KittiSource, RefusesACalibrationThatIsNone) {
  MakeRecording("image_0", "image_1");
  WriteText("calib.txt", "P0: 0 0 32 0 0 50 24 0 0 0 1 0\n");
  EXPECT_EQ(Open(SensorType::kMono).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(SharedKitti, PlaysToTheEnd) {
  const std::string folder = SharedDataFolder() + "/sequences/kitti06_stereo51";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no shared sequence at " << folder;
  const auto source = OpenSource("kitti:" + folder, ForSensor(SensorType::kStereo));
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->rig().camera.width, 1226);
  EXPECT_NEAR((*source)->rig().baseline_m, 0.5371, 1e-3);
  EXPECT_NEAR(PathLength(*(*source)->ground_truth()), 59.9, 0.05);
  EXPECT_EQ(CountFrames(**source), 51);
}

}  // namespace
}  // namespace semmap::client
