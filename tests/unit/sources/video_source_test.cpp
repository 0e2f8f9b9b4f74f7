#include <opencv2/videoio.hpp>

#include "tests/unit/sources/source_test_util.h"

namespace semmap::client {
namespace {

class VideoSource : public SourceTest {
 protected:
  // Ten grey frames of growing brightness at 5 Hz.
  void SetUp() override {
    SourceTest::SetUp();
    cv::VideoWriter writer(Path("v.avi"), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 5.0, {64, 48});
    if (!writer.isOpened()) GTEST_SKIP() << "this OpenCV cannot write a video";
    for (int i = 0; i < 10; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(20 * i)));
    WriteText("camera.yaml", kSmallCamera);
  }
};

TEST_F(VideoSource, PlaysGreyFramesWithGrowingTimes) {
  const auto source = OpenSource("video:" + Path("v.avi"), ForSensor(SensorType::kMono, Path("camera.yaml")));
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_DOUBLE_EQ((*source)->rig().frames_per_second, 5.0);
  EXPECT_EQ((*source)->frame_count(), 10U);
  TimestampNs last = -1;
  for (int i = 0; i < 10; ++i) {
    const auto frame = (*source)->Next();
    ASSERT_TRUE(frame.ok() && frame->has_value()) << i;
    EXPECT_NEAR(LevelOf((*frame)->image), 20 * i, 3);
    EXPECT_GT((*frame)->timestamp, last);
    EXPECT_NEAR(ToSeconds((*frame)->timestamp), 0.2 * i, 0.21);
    last = (*frame)->timestamp;
  }
  EXPECT_FALSE((*source)->Next()->has_value());
}

TEST_F(VideoSource, RefusesWhatDoesNotFit) {
  const std::string spec = "video:" + Path("v.avi");
  EXPECT_FALSE(OpenSource(spec, ForSensor(SensorType::kMono)).ok());
  EXPECT_FALSE(OpenSource(spec, ForSensor(SensorType::kStereo, Path("camera.yaml"))).ok());
  EXPECT_EQ(OpenSource("video:" + Path("none.avi"), ForSensor(SensorType::kMono, Path("camera.yaml")))
                .status()
                .code(),
            absl::StatusCode::kNotFound);
  WriteText("big.yaml", "width: 65\nheight: 48\nfx: 50\nfy: 50\ncx: 32\ncy: 24\n");
  const auto source = OpenSource(spec, ForSensor(SensorType::kMono, Path("big.yaml")));
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->Next().status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace semmap::client
