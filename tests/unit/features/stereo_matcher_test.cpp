#include "slam/features/stereo_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "slam/common/config_reader.h"
#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

constexpr double kFocal = 500;
constexpr double kBaseline = 0.5;

struct StereoFeatures {
  FrameFeatures left;
  FrameFeatures right;
};

StereoFeatures MatchPair(const cv::Mat& left, const cv::Mat& right, const StereoConfig& config = {}) {
  OrbExtractor left_extractor(OrbConfig{});
  OrbExtractor right_extractor(OrbConfig{});
  StereoFeatures features;
  left_extractor.Extract(left, &features.left);
  right_extractor.Extract(right, &features.right);
  StereoMatcher matcher(config, kFocal, kBaseline);
  matcher.Match(left_extractor, right_extractor, features.right, &features.left);
  return features;
}

int CountWithDepth(const FrameFeatures& features) {
  return static_cast<int>(std::count_if(features.keypoints.begin(), features.keypoints.end(),
                                        [](const Keypoint& k) { return k.HasDepth(); }));
}

// What the right camera sees of a plane whose disparity grows down the image: disparity = base + slope * row.
cv::Mat RightViewOfPlane(const cv::Mat& left, double base, double slope) {
  cv::Mat map_x(left.size(), CV_32F);
  cv::Mat map_y(left.size(), CV_32F);
  for (int y = 0; y < left.rows; ++y) {
    for (int x = 0; x < left.cols; ++x) {
      map_x.at<float>(y, x) = static_cast<float>(x + base + slope * y);
      map_y.at<float>(y, x) = static_cast<float>(y);
    }
  }
  cv::Mat right;
  cv::remap(left, right, map_x, map_y, cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
  return right;
}

TEST(StereoMatcher, FindsKnownDisparitiesBelowAPixel) {
  const cv::Mat left = test::TexturedImage({900, 500}, 21);
  for (const double base : {2.0, 7.3, 24.5, 60.8}) {
    const double slope = 0.03;
    StereoConfig all;
    all.max_depth_in_baselines = 800;
    const StereoFeatures features = MatchPair(left, RightViewOfPlane(left, base, slope), all);
    std::vector<double> errors;
    for (const Keypoint& keypoint : features.left.keypoints) {
      if (!keypoint.HasDepth()) continue;
      const double disparity = base + slope * keypoint.y;
      errors.push_back(std::abs(keypoint.x - keypoint.right_x - disparity));
      ASSERT_NEAR(keypoint.depth, kFocal * kBaseline / (keypoint.x - keypoint.right_x),
                  1e-3 * keypoint.depth);
    }
    ASSERT_GT(errors.size(), 1000u) << base;
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() / 2], 0.12) << base;
    EXPECT_LT(errors[errors.size() * 95 / 100], 1.5) << base;
  }
}

TEST(StereoMatcher, UnrelatedImagesGiveHardlyAnyDepth) {
  const StereoFeatures features =
      MatchPair(test::TexturedImage({640, 480}, 22), test::TexturedImage({640, 480}, 23));
  EXPECT_LT(CountWithDepth(features.left), 100);
}

TEST(StereoMatcher, PointsBehindInfinityOrTooFarHaveNoDepth) {
  const cv::Mat left = test::TexturedImage({640, 480}, 24);
  // The right image shifted the wrong way: negative disparities.
  EXPECT_LT(CountWithDepth(MatchPair(left, RightViewOfPlane(left, -12, 0)).left), 60);
  StereoConfig near_only;
  near_only.max_depth_in_baselines = 50;  // at least 10 pixels of disparity
  near_only.min_depths = 0;
  EXPECT_LT(CountWithDepth(MatchPair(left, RightViewOfPlane(left, 8, 0), near_only).left), 60);
  EXPECT_GT(CountWithDepth(MatchPair(left, RightViewOfPlane(left, 12, 0), near_only).left), 800);
}

TEST(StereoMatcher, WhereNothingIsNearTheNearestGetDepth) {
  const cv::Mat left = test::TexturedImage({640, 480}, 24);
  const cv::Mat right = RightViewOfPlane(left, 8, 0.005);  // 6.4 to 9.6 pixels
  StereoConfig config;
  config.max_depth_in_baselines = 50;  // at least 10 pixels of disparity
  config.min_depths = 200;
  const StereoFeatures found = MatchPair(left, right, config);
  EXPECT_NEAR(CountWithDepth(found.left), 200, 2);
  float least = 1000;
  for (const Keypoint& keypoint : found.left.keypoints) {
    if (keypoint.HasDepth()) least = std::min(least, keypoint.x - keypoint.right_x);
  }
  EXPECT_GT(least, 8.0F);
}

TEST(StereoMatcher, OldDepthIsForgotten) {
  OrbExtractor left(OrbConfig{});
  OrbExtractor right(OrbConfig{});
  FrameFeatures left_features;
  FrameFeatures right_features;
  left.Extract(test::TexturedImage({320, 240}, 25), &left_features);
  right.Extract(cv::Mat::zeros(240, 320, CV_8UC1), &right_features);
  for (Keypoint& keypoint : left_features.keypoints) keypoint.depth = keypoint.right_x = 5;
  StereoMatcher({}, kFocal, kBaseline).Match(left, right, right_features, &left_features);
  ASSERT_GT(left_features.size(), 0u);
  for (const Keypoint& keypoint : left_features.keypoints) {
    EXPECT_FALSE(keypoint.HasDepth());
    EXPECT_LT(keypoint.right_x, 0);
  }
}

TEST(StereoMatcher, ImagesOfDifferentSizesAndNoImagesGiveNoDepth) {
  EXPECT_EQ(CountWithDepth(
                MatchPair(test::TexturedImage({640, 480}, 26), test::TexturedImage({320, 240}, 26)).left),
            0);
  EXPECT_EQ(CountWithDepth(MatchPair(cv::Mat(), test::TexturedImage({320, 240}, 26)).left), 0);
}

TEST(StereoMatcher, SameInputSameOutput) {
  const cv::Mat left = test::TexturedImage({640, 480}, 27);
  const cv::Mat right = RightViewOfPlane(left, 9.4, 0.02);
  const StereoFeatures first = MatchPair(left, right);
  const StereoFeatures second = MatchPair(left, right);
  ASSERT_EQ(first.left.size(), second.left.size());
  for (size_t i = 0; i < first.left.size(); ++i) {
    ASSERT_EQ(first.left.keypoints[i].right_x, second.left.keypoints[i].right_x);
    ASSERT_EQ(first.left.keypoints[i].depth, second.left.keypoints[i].depth);
  }
}

TEST(StereoConfig, ReadsAndRefuses) {
  auto reader = ConfigReader::FromText("max_descriptor_distance: 60\nmax_depth_in_baselines: 40\n", "test");
  ASSERT_TRUE(reader.ok());
  StereoConfig config;
  config.Read(*reader);
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(config.max_descriptor_distance, 60);
  EXPECT_EQ(config.max_depth_in_baselines, 40);
  auto bad = ConfigReader::FromText("max_descriptor_distance: 300\n", "test");
  ASSERT_TRUE(bad.ok());
  config.Read(*bad);
  EXPECT_FALSE(bad->Finish().ok());
}

}  // namespace
}  // namespace semmap
