#include "server/frame_decoder.h"

#include <gtest/gtest.h>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

v1::Image Raw(v1::ImageEncoding encoding, size_t bytes_per_pixel) {
  v1::Image image;
  image.set_encoding(encoding);
  image.set_width(64);
  image.set_height(48);
  image.set_data(std::string(64 * 48 * bytes_per_pixel, '\x05'));
  return image;
}

v1::Image Grey() { return Raw(v1::IMAGE_ENCODING_RAW_GRAY8, 1); }
v1::Image Depth() { return Raw(v1::IMAGE_ENCODING_RAW_DEPTH16, 2); }

CameraRig Rig(SensorType sensor) {
  CameraRig rig;
  rig.sensor = sensor;
  rig.camera.width = 64;
  rig.camera.height = 48;
  return rig;
}

TEST(FrameDecoder, BringsWhatTheSensorHas) {
  v1::Frame frame;
  frame.set_sequence(9);
  frame.set_timestamp_ns(77);
  *frame.mutable_image() = Grey();
  *frame.mutable_class_mask() = Grey();
  auto input = DecodeFrame(frame, Rig(SensorType::kMono), false);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->sequence, 9U);
  EXPECT_EQ(input->timestamp, 77);
  EXPECT_EQ(input->image.size(), cv::Size(64, 48));
  EXPECT_EQ(input->class_mask.at<uchar>(0, 0), 5);
  EXPECT_TRUE(input->right.empty());
  *frame.mutable_right() = Grey();
  input = DecodeFrame(frame, Rig(SensorType::kStereo), false);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->right.type(), CV_8UC1);
  frame.clear_right();
  *frame.mutable_depth() = Depth();
  input = DecodeFrame(frame, Rig(SensorType::kRgbd), false);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->depth.type(), CV_16UC1);
}

TEST(FrameDecoder, RefusesImagesThatContradictTheRig) {
  v1::Frame frame;
  EXPECT_EQ(ReasonOf(DecodeFrame(frame, Rig(SensorType::kMono), false).status()),
            v1::ERROR_REASON_IMAGE_MISSING);
  *frame.mutable_image() = Grey();
  EXPECT_EQ(ReasonOf(DecodeFrame(frame, Rig(SensorType::kStereo), false).status()),
            v1::ERROR_REASON_IMAGE_MISSING);
  EXPECT_EQ(ReasonOf(DecodeFrame(frame, Rig(SensorType::kRgbd), false).status()),
            v1::ERROR_REASON_IMAGE_MISSING);
  *frame.mutable_right() = Grey();
  EXPECT_EQ(ReasonOf(DecodeFrame(frame, Rig(SensorType::kMono), false).status()),
            v1::ERROR_REASON_IMAGE_UNEXPECTED);
  frame.mutable_right()->set_width(32);
  EXPECT_EQ(ReasonOf(DecodeFrame(frame, Rig(SensorType::kStereo), false).status()),
            v1::ERROR_REASON_IMAGE_SIZE_MISMATCH);
}

TEST(FrameDecoder, KeepsColoursForWhoWantsThem) {
  v1::Frame frame;
  *frame.mutable_image() = Raw(v1::IMAGE_ENCODING_RAW_BGR8, 3);
  EXPECT_TRUE(DecodeFrame(frame, Rig(SensorType::kMono), false)->colour.empty());
  const auto input = DecodeFrame(frame, Rig(SensorType::kMono), true);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->image.type(), CV_8UC1);
  EXPECT_EQ(input->colour.type(), CV_8UC3);
  EXPECT_EQ(input->colour.size(), cv::Size(64, 48));
  // Who sends a mask needs no segmentation.
  *frame.mutable_class_mask() = Grey();
  EXPECT_TRUE(DecodeFrame(frame, Rig(SensorType::kMono), true)->colour.empty());
}

}  // namespace
}  // namespace semmap::server
