#include <gmock/gmock.h>

#include "tests/unit/sources/source_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

class FolderSource : public SourceTest {
 protected:
  absl::StatusOr<std::unique_ptr<FrameSource>> Open(SensorType sensor, const std::string& camera = "") {
    return OpenSource("folder:" + root_.string(), ForSensor(sensor, camera));
  }
};

TEST_F(FolderSource, PlaysInNaturalOrderAtTheCameraFilesRate) {
  for (const int i : {1, 2, 10}) WriteGray("frame" + std::to_string(i) + ".png", 40 + i);
  WriteText("camera.yaml", std::string(kSmallCamera) + "frames_per_second: 4\n");
  const auto source = Open(SensorType::kMono);
  ASSERT_TRUE(source.ok()) << source.status();
  for (const int expected : {41, 42, 50}) {
    const auto frame = (*source)->Next();
    ASSERT_TRUE(frame.ok() && frame->has_value());
    EXPECT_EQ(LevelOf((*frame)->image), expected);
    EXPECT_EQ((*frame)->timestamp, static_cast<TimestampNs>((*frame)->sequence) * 250'000'000);
  }
}

TEST_F(FolderSource, TakesStereoAndDepthSubfolders) {
  for (int i = 0; i < 3; ++i) {
    WriteGray("left/" + std::to_string(i) + ".png", 50 + i);
    WriteGray("right/r" + std::to_string(i) + ".png", 60 + i);
    WriteDepth("depth/" + std::to_string(i) + ".png", 70 + i);
  }
  WriteText("elsewhere.yaml", std::string(kSmallCamera) + "baseline_m: 0.1\n");
  WriteText("times.txt", "5\n6\n8\n");
  WriteText("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n");
  auto source = Open(SensorType::kStereo, Path("elsewhere.yaml"));
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->ground_truth()->poses[1].timestamp, 6'000'000'000);
  auto frame = (*source)->Next();
  EXPECT_EQ(LevelOf((*frame)->image), 50);
  EXPECT_EQ(LevelOf((*frame)->right), 60);
  EXPECT_EQ((*frame)->timestamp, 5'000'000'000);
  source = Open(SensorType::kRgbd, Path("elsewhere.yaml"));
  ASSERT_TRUE(source.ok()) << source.status();
  frame = (*source)->Next();
  EXPECT_EQ(DecodeDepth((*frame)->depth)->at<uint16_t>(0, 0), 70);
}

TEST_F(FolderSource, SaysWhatIsMissing) {
  WriteGray("left/0.png", 1);
  EXPECT_THAT(std::string(Open(SensorType::kMono).status().message()), HasSubstr("--camera"));
  WriteText("camera.yaml", std::string(kSmallCamera) + "baseline_m: 0.1\n");
  EXPECT_TRUE(Open(SensorType::kMono).ok());
  EXPECT_THAT(std::string(Open(SensorType::kStereo).status().message()), HasSubstr("right images"));
  WriteGray("right/0.png", 1);
  WriteGray("right/1.png", 1);
  EXPECT_THAT(std::string(Open(SensorType::kStereo).status().message()), HasSubstr("2 images for 1 frames"));
}

TEST(OpenSource, RefusesUnknownKinds) {
  for (const char* spec : {"", "kitti", "kitti:", "rosbag:x", ":x"}) {
    EXPECT_EQ(OpenSource(spec, {}).status().code(), absl::StatusCode::kInvalidArgument) << spec;
  }
}

}  // namespace
}  // namespace semmap::client
