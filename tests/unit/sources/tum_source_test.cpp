#include <gmock/gmock.h>

#include "tests/unit/sources/source_test_util.h"

namespace semmap::client {
namespace {

using ::testing::HasSubstr;

class TumSource : public SourceTest {
 protected:
  // Colour at 0.00, 0.10, 0.20; depth 5 ms later but for the second.
  void MakeRecording(const std::string& folder) {
    WriteText(folder + "/rgb.txt", "# colour\n10.00 rgb/0.png\n10.10 rgb/1.png\n10.20 rgb/2.png\n");
    WriteText(folder + "/depth.txt", "# depth\n10.005 depth/0.png\n10.205 depth/2.png\n");
    for (int i = 0; i < 3; ++i) {
      WriteGray(folder + "/rgb/" + std::to_string(i) + ".png", 30 + i, {640, 480});
      WriteDepth(folder + "/depth/" + std::to_string(i) + ".png", 1000 + i);
    }
  }
  absl::StatusOr<std::unique_ptr<FrameSource>> Open(const std::string& folder,
                                                    SensorType sensor = SensorType::kRgbd) {
    return OpenSource("tum:" + Path(folder), ForSensor(sensor));
  }
};

TEST_F(TumSource, AssociatesByTime) {
  MakeRecording("x");
  const auto source = Open("x");
  ASSERT_TRUE(source.ok()) << source.status();
  ASSERT_EQ((*source)->frame_count(), 2U);
  (void)(*source)->Next();
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame.ok() && frame->has_value());
  EXPECT_EQ((*frame)->timestamp, 10'200'000'000);
  EXPECT_EQ(LevelOf((*frame)->image), 32);
  EXPECT_EQ(DecodeDepth((*frame)->depth)->at<uint16_t>(0, 0), 1002);
  EXPECT_EQ((*Open("x", SensorType::kMono))->frame_count(), 3U);
}

TEST_F(TumSource, PrefersAssociationsInEitherOrder) {
  MakeRecording("x");
  WriteText("x/associations.txt", "10.10 rgb/1.png 10.205 depth/2.png\n");
  auto frame = (*Open("x"))->Next();
  EXPECT_EQ(DecodeDepth((*frame)->depth)->at<uint16_t>(0, 0), 1002);
  EXPECT_EQ(LevelOf((*frame)->image), 31);
  WriteText("x/associations.txt", "10.205 depth/2.png 10.10 rgb/1.png\n");
  frame = (*Open("x"))->Next();
  EXPECT_EQ((*frame)->timestamp, 10'100'000'000);
  EXPECT_EQ(DecodeDepth((*frame)->depth)->at<uint16_t>(0, 0), 1002);
  EXPECT_EQ(LevelOf((*frame)->image), 31);
}

TEST_F(TumSource, RecognisesThePublishedCalibrations) {
  for (const auto& [name, fx, units] :
       {std::tuple{"rgbd_dataset_freiburg1_desk", 517.3, 5000.0},
        std::tuple{"rgbd_dataset_freiburg2_xyz", 520.9, 5000.0},
        std::tuple{"rgbd_dataset_freiburg3_office", 535.4, 5000.0}, std::tuple{"other", 525.0, 5000.0}}) {
    MakeRecording(name);
    const auto source = Open(name);
    ASSERT_TRUE(source.ok()) << source.status();
    EXPECT_DOUBLE_EQ((*source)->rig().camera.fx, fx) << name;
    EXPECT_DOUBLE_EQ((*source)->rig().depth_units_per_metre, units);
  }
  EXPECT_EQ((*Open("rgbd_dataset_freiburg1_desk"))->rig().camera.distortion_model,
            DistortionModel::kRadialTangential);
  EXPECT_EQ((*Open("rgbd_dataset_freiburg3_office"))->rig().camera.distortion_model, DistortionModel::kNone);
}

TEST_F(TumSource, OwnCalibrationFilesComeFirst) {
  MakeRecording("freiburg1");
  WriteText("freiburg1/camera-intrinsics.txt", "585 0 320\n0 586 240\n0 0 1\n");
  auto source = Open("freiburg1");
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_DOUBLE_EQ((*source)->rig().camera.fy, 586);
  EXPECT_DOUBLE_EQ((*source)->rig().depth_units_per_metre, 1000);
  WriteText("freiburg1/camera.yaml", "width: 640\nheight: 480\nfx: 600\nfy: 600\ncx: 320\ncy: 240\n");
  source = Open("freiburg1");
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_DOUBLE_EQ((*source)->rig().camera.fx, 600);
}

TEST_F(TumSource, SaysWhatIsWrong) {
  MakeRecording("x");
  EXPECT_EQ(Open("x", SensorType::kStereo).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(Open("nothing").status().code(), absl::StatusCode::kNotFound);
  WriteText("x/rgb.txt", "10.0 rgb/0.png\n9.0 rgb/1.png\n");
  EXPECT_THAT(std::string(Open("x").status().message()), HasSubstr("rgb.txt:2: the time is not later"));
  WriteText("x/rgb.txt", "10.0\n");
  EXPECT_THAT(std::string(Open("x").status().message()), HasSubstr("rgb.txt:1: expected a time and a file"));
}

TEST_F(TumSource, AMissingImageIsAnErrorOfThatFrame) {
  MakeRecording("x");
  std::filesystem::remove(Path("x/rgb/2.png"));
  auto source = Open("x");
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_TRUE((*source)->Next().ok());
  EXPECT_EQ((*source)->Next().status().code(), absl::StatusCode::kNotFound);
}

TEST(SharedTum, PlaysToTheEnd) {
  const std::string folder = SharedDataFolder() + "/sequences/rgbd_kitchen200";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no shared sequence at " << folder;
  const auto source = OpenSource("tum:" + folder, ForSensor(SensorType::kRgbd));
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_DOUBLE_EQ((*source)->rig().camera.fx, 585);
  EXPECT_DOUBLE_EQ((*source)->rig().depth_units_per_metre, 1000);
  EXPECT_NEAR((*source)->rig().frames_per_second, 30, 0.1);
  EXPECT_EQ((*source)->ground_truth()->size(), 200U);
  EXPECT_EQ(CountFrames(**source), 200);
}

}  // namespace
}  // namespace semmap::client
