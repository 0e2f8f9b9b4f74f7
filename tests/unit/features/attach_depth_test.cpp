#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "slam/features/stereo_matcher.h"

namespace semmap {
namespace {

// Keypoints at the pixels themselves, with an old depth that has to go.
FrameFeatures FeaturesAt(const std::vector<cv::Point2f>& pixels) {
  FrameFeatures features;
  for (const cv::Point2f& pixel : pixels) {
    Keypoint keypoint;
    keypoint.x = pixel.x;
    keypoint.y = pixel.y;
    keypoint.depth = keypoint.right_x = 77;
    features.keypoints.push_back(keypoint);
  }
  features.descriptors.resize(pixels.size());
  return features;
}

TEST(AttachDepth, SixteenBitInUnits) {
  cv::Mat depth(10, 20, CV_16UC1, cv::Scalar(2500));
  depth.at<uint16_t>(3, 4) = 0;
  depth.at<uint16_t>(3, 5) = 65535;
  depth.at<uint16_t>(3, 6) = 65534;
  const std::vector<cv::Point2f> pixels = {{2, 2}, {4, 3}, {5, 3}, {6.4F, 2.6F}};
  FrameFeatures features = FeaturesAt(pixels);
  AttachDepth(depth, 1000, 50, pixels, &features);
  EXPECT_FLOAT_EQ(features.keypoints[0].depth, 2.5F);
  EXPECT_FLOAT_EQ(features.keypoints[0].right_x, 2 - 50 / 2.5F);
  EXPECT_FALSE(features.keypoints[1].HasDepth());
  EXPECT_FALSE(features.keypoints[2].HasDepth());
  EXPECT_EQ(features.keypoints[2].right_x, -1);
  EXPECT_FLOAT_EQ(features.keypoints[3].depth, 65.534F);
}

TEST(AttachDepth, FloatInMetres) {
  cv::Mat depth(10, 20, CV_32FC1, cv::Scalar(4));
  depth.at<float>(0, 1) = std::numeric_limits<float>::quiet_NaN();
  depth.at<float>(0, 2) = std::numeric_limits<float>::infinity();
  depth.at<float>(0, 3) = -1;
  depth.at<float>(0, 4) = 0;
  const std::vector<cv::Point2f> pixels = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}};
  FrameFeatures features = FeaturesAt(pixels);
  AttachDepth(depth, 1000, 8, pixels, &features);
  EXPECT_FLOAT_EQ(features.keypoints[0].depth, 4);
  EXPECT_FLOAT_EQ(features.keypoints[0].right_x, -2);
  for (size_t i = 1; i < pixels.size(); ++i) EXPECT_FALSE(features.keypoints[i].HasDepth()) << i;
}

TEST(AttachDepth, ReadsAtRawPixelsButCountsFromUndistortedOnes) {
  cv::Mat depth(10, 20, CV_32FC1, cv::Scalar(1));
  depth.at<float>(7, 9) = 2;
  FrameFeatures features = FeaturesAt({{12, 8}});
  AttachDepth(depth, 1, 10, {{9.3F, 6.8F}}, &features);
  EXPECT_FLOAT_EQ(features.keypoints[0].depth, 2);
  EXPECT_FLOAT_EQ(features.keypoints[0].right_x, 7);
}

TEST(AttachDepth, OutsideTheImageThereIsNone) {
  const cv::Mat depth(10, 20, CV_32FC1, cv::Scalar(1));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<cv::Point2f> pixels = {{-0.6F, 0}, {19.6F, 0}, {0, 9.6F},    {nan, 0},
                                           {0, nan},   {1e9F, 0},  {-0.4F, 9.4F}};
  FrameFeatures features = FeaturesAt(pixels);
  AttachDepth(depth, 1, 10, pixels, &features);
  for (size_t i = 0; i + 1 < pixels.size(); ++i) EXPECT_FALSE(features.keypoints[i].HasDepth()) << i;
  EXPECT_TRUE(features.keypoints.back().HasDepth());
}

TEST(AttachDepth, UnreadableImagesAndMissingPixelsGiveNone) {
  const std::vector<cv::Point2f> pixels = {{1, 1}, {2, 2}};
  for (const cv::Mat& depth :
       {cv::Mat(), cv::Mat(5, 5, CV_8UC1, cv::Scalar(3)), cv::Mat(5, 5, CV_64FC1, cv::Scalar(3))}) {
    FrameFeatures features = FeaturesAt(pixels);
    AttachDepth(depth, 1, 10, pixels, &features);
    EXPECT_FALSE(features.keypoints[0].HasDepth());
  }
  const cv::Mat depth(5, 5, CV_16UC1, cv::Scalar(3));
  FrameFeatures no_units = FeaturesAt(pixels);
  AttachDepth(depth, 0, 10, pixels, &no_units);
  EXPECT_FALSE(no_units.keypoints[0].HasDepth());
  FrameFeatures short_of_pixels = FeaturesAt(pixels);
  AttachDepth(depth, 1, 10, {{1, 1}}, &short_of_pixels);
  EXPECT_TRUE(short_of_pixels.keypoints[0].HasDepth());
  EXPECT_FALSE(short_of_pixels.keypoints[1].HasDepth());
}

}  // namespace
}  // namespace semmap
