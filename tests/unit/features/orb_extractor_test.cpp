#include "slam/features/orb_extractor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "slam/common/config_reader.h"
#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

FrameFeatures Extract(const cv::Mat& image, const OrbConfig& config = {}) {
  FrameFeatures features;
  OrbExtractor(config).Extract(image, &features);
  return features;
}

bool SameBytes(const FrameFeatures& a, const FrameFeatures& b) {
  if (a.size() != b.size() || a.descriptors != b.descriptors) return false;
  return std::equal(a.keypoints.begin(), a.keypoints.end(), b.keypoints.begin(),
                    [](const Keypoint& p, const Keypoint& q) {
                      return p.x == q.x && p.y == q.y && p.angle == q.angle && p.octave == q.octave;
                    });
}

// Share of cells of the image that hold a keypoint; a border is left out, where corners lack room.
double OccupiedShare(const std::vector<Keypoint>& keypoints, const cv::Size& size, int cell, int border) {
  const int columns = (size.width - 2 * border) / cell;
  const int rows = (size.height - 2 * border) / cell;
  std::set<std::pair<int, int>> occupied;
  for (const Keypoint& keypoint : keypoints) {
    const int column =
        static_cast<int>(std::floor((keypoint.x - static_cast<float>(border)) / static_cast<float>(cell)));
    const int row =
        static_cast<int>(std::floor((keypoint.y - static_cast<float>(border)) / static_cast<float>(cell)));
    if (column >= 0 && column < columns && row >= 0 && row < rows) occupied.insert({column, row});
  }
  return static_cast<double>(occupied.size()) / (columns * rows);
}

// The mutual nearest neighbours whose positions agree with `expected` (first image to second) within
// `tolerance` pixels of their level, as a share of all mutual nearest neighbours.
struct MatchQuality {
  int mutual = 0;
  int correct = 0;
  double mean_angle_error = 0;
};

template <typename Map>
MatchQuality MatchAgainst(const FrameFeatures& a, const FrameFeatures& b, Map&& expected, double rotation,
                          double tolerance) {
  const auto nearest = [](const Descriptor& query, const std::vector<Descriptor>& candidates) {
    return std::min_element(candidates.begin(), candidates.end(),
                            [&](const Descriptor& p, const Descriptor& q) {
                              return HammingDistance(query, p) < HammingDistance(query, q);
                            }) -
           candidates.begin();
  };
  MatchQuality quality;
  for (size_t i = 0; i < a.size(); ++i) {
    const auto j = nearest(a.descriptors[i], b.descriptors);
    if (nearest(b.descriptors[j], a.descriptors) != static_cast<ptrdiff_t>(i)) continue;
    ++quality.mutual;
    const cv::Point2d target = expected(cv::Point2d(a.keypoints[i].x, a.keypoints[i].y));
    const double scale = std::pow(1.2, b.keypoints[j].octave);
    if (cv::norm(target - cv::Point2d(b.keypoints[j].x, b.keypoints[j].y)) > tolerance * scale) continue;
    ++quality.correct;
    quality.mean_angle_error += std::abs(
        std::remainder(b.keypoints[j].angle - a.keypoints[i].angle - rotation, 2 * std::numbers::pi));
  }
  if (quality.correct > 0) quality.mean_angle_error /= quality.correct;
  return quality;
}

TEST(OrbExtractor, GivesTheNumberAskedForSpreadOverTheImage) {
  const cv::Mat image = test::TexturedImage({960, 480}, 1);
  const FrameFeatures features = Extract(image);
  EXPECT_EQ(features.size(), 2000u);
  EXPECT_EQ(features.descriptors.size(), 2000u);
  EXPECT_GT(OccupiedShare(features.keypoints, image.size(), 40, 20), 0.9);
}

TEST(OrbExtractor, LowContrastHalfKeepsItsShare) {
  cv::Mat image = test::TexturedImage({960, 480}, 2);
  cv::Mat left = image(cv::Rect(0, 0, 480, 480));
  left.convertTo(left, CV_8U, 0.12, 110);
  const FrameFeatures features = Extract(image);
  const auto in_left = std::count_if(features.keypoints.begin(), features.keypoints.end(),
                                     [](const Keypoint& keypoint) { return keypoint.x < 480; });
  EXPECT_GT(in_left, 600);
  // Without the second threshold the dim half has next to nothing.
  OrbConfig strict;
  strict.min_fast_threshold = strict.fast_threshold;
  const FrameFeatures strict_features = Extract(image, strict);
  const auto in_left_strict =
      std::count_if(strict_features.keypoints.begin(), strict_features.keypoints.end(),
                    [](const Keypoint& keypoint) { return keypoint.x < 470; });
  EXPECT_LT(in_left_strict, in_left / 4);
}

TEST(OrbExtractor, KeypointsAreInsideAndWellFormed) {
  const cv::Mat image = test::TexturedImage({641, 359}, 3);
  OrbExtractor extractor(OrbConfig{});
  FrameFeatures features;
  extractor.Extract(image, &features);
  std::vector<int> per_level(8);
  for (const Keypoint& keypoint : features.keypoints) {
    EXPECT_GE(keypoint.x, 10);
    EXPECT_GE(keypoint.y, 10);
    EXPECT_LT(keypoint.x, 631);
    EXPECT_LT(keypoint.y, 349);
    EXPECT_GE(keypoint.angle, 0);
    EXPECT_LT(keypoint.angle, 2 * std::numbers::pi);
    EXPECT_FALSE(keypoint.HasDepth());
    ASSERT_LT(keypoint.octave, 8);
    ++per_level[keypoint.octave];
  }
  for (int level = 1; level < 8; ++level) EXPECT_GE(per_level[level - 1], per_level[level]) << level;
  EXPECT_GT(per_level[7], 50);
  ASSERT_EQ(extractor.pyramid().size(), 8u);
  EXPECT_EQ(cv::norm(extractor.pyramid()[0], image, cv::NORM_INF), 0);
  EXPECT_EQ(extractor.pyramid()[1].size(), cv::Size(534, 299));
}

TEST(OrbExtractor, TwoExtractorsAndRepeatedCallsAgreeByteForByte) {
  const cv::Mat image = test::TexturedImage({752, 480}, 4);
  const cv::Mat other = test::TexturedImage({300, 200}, 5);
  const FrameFeatures expected = Extract(image);
  OrbExtractor extractor(OrbConfig{});
  FrameFeatures features;
  for (int repetition = 0; repetition < 3; ++repetition) {
    // Another image size in between must leave no trace.
    extractor.Extract(other, &features);
    extractor.Extract(image, &features);
    ASSERT_TRUE(SameBytes(features, expected));
  }
  // A window into a larger image is the same image.
  cv::Mat framed;
  cv::copyMakeBorder(image, framed, 20, 20, 20, 20, cv::BORDER_CONSTANT, cv::Scalar(255));
  EXPECT_TRUE(SameBytes(Extract(framed(cv::Rect(20, 20, 752, 480))), expected));
}

TEST(OrbExtractor, OrientationAndDescriptorsFollowARotation) {
  const cv::Mat image = test::TexturedImage({640, 640}, 6);
  const FrameFeatures upright = Extract(image);
  for (const double degrees : {25.0, 90.0, 163.0}) {
    const cv::Mat transform = cv::getRotationMatrix2D({319.5F, 319.5F}, degrees, 1.0);
    cv::Mat rotated;
    cv::warpAffine(image, rotated, transform, image.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
    const auto map = [&](const cv::Point2d& p) {
      return cv::Point2d(
          transform.at<double>(0, 0) * p.x + transform.at<double>(0, 1) * p.y + transform.at<double>(0, 2),
          transform.at<double>(1, 0) * p.x + transform.at<double>(1, 1) * p.y + transform.at<double>(1, 2));
    };
    // OpenCV's angles are anticlockwise, those of keypoints clockwise.
    const MatchQuality quality =
        MatchAgainst(upright, Extract(rotated), map, -degrees * std::numbers::pi / 180, 1.5);
    EXPECT_GT(quality.correct, 400) << degrees;
    EXPECT_GT(quality.correct, 0.75 * quality.mutual) << degrees;
    EXPECT_LT(quality.mean_angle_error, 0.12) << degrees;
  }
}

TEST(OrbExtractor, ScaledImageIsMatchedAcrossLevels) {
  const cv::Mat image = test::TexturedImage({800, 600}, 7);
  cv::Mat half;
  cv::resize(image, half, cv::Size(), 1 / 1.44, 1 / 1.44, cv::INTER_AREA);
  const auto map = [&](const cv::Point2d& p) {
    return cv::Point2d((p.x + 0.5) * half.cols / image.cols - 0.5,
                       (p.y + 0.5) * half.rows / image.rows - 0.5);
  };
  const FrameFeatures a = Extract(image);
  const FrameFeatures b = Extract(half);
  const MatchQuality quality = MatchAgainst(a, b, map, 0, 1.5);
  EXPECT_GT(quality.correct, 400);
  EXPECT_GT(quality.correct, 0.75 * quality.mutual);
}

TEST(OrbExtractor, ImagesWithoutCornersGiveNone) {
  EXPECT_EQ(Extract(cv::Mat::zeros(480, 640, CV_8UC1)).size(), 0u);
  EXPECT_EQ(Extract(cv::Mat(480, 640, CV_8UC1, cv::Scalar(255))).size(), 0u);
  cv::Mat ramp(480, 640, CV_8UC1);
  for (int x = 0; x < ramp.cols; ++x) ramp.col(x).setTo(x / 3);
  EXPECT_EQ(Extract(ramp).size(), 0u);
}

TEST(OrbExtractor, ImagesThatItCannotTakeGiveNone) {
  EXPECT_EQ(Extract(cv::Mat()).size(), 0u);
  EXPECT_EQ(Extract(test::TexturedImage({63, 200}, 8)).size(), 0u);
  EXPECT_EQ(Extract(cv::Mat::zeros(480, 640, CV_8UC3)).size(), 0u);
}

TEST(OrbExtractor, SmallAndOddSizes) {
  OrbExtractor extractor(OrbConfig{});
  FrameFeatures features;
  for (const cv::Size size : {cv::Size(64, 64), cv::Size(65, 67), cv::Size(127, 64), cv::Size(64, 401),
                              cv::Size(191, 193), cv::Size(1001, 99)}) {
    extractor.Extract(test::TexturedImage(size, 9), &features);
    EXPECT_GT(features.size(), 10u) << size;
    EXPECT_LE(features.size(), 2000u) << size;
    for (const Keypoint& keypoint : features.keypoints) {
      EXPECT_TRUE(keypoint.x >= 0 && keypoint.x < static_cast<float>(size.width)) << size;
      EXPECT_TRUE(keypoint.y >= 0 && keypoint.y < static_cast<float>(size.height)) << size;
    }
  }
}

TEST(OrbExtractor, NumberOfLevelsAndFeaturesIsConfigurable) {
  const cv::Mat image = test::TexturedImage({640, 480}, 10);
  for (const int levels : {1, 3, 12}) {
    OrbConfig config;
    config.levels = levels;
    config.features = 500;
    const FrameFeatures features = Extract(image, config);
    EXPECT_EQ(features.size(), 500u) << levels;
    for (const Keypoint& keypoint : features.keypoints) EXPECT_LT(keypoint.octave, levels);
  }
}

TEST(OrbConfig, ReadsAndRefuses) {
  auto reader = ConfigReader::FromText("features: 1200\nfast_threshold: 12\nmin_fast_threshold: 5\n", "test");
  ASSERT_TRUE(reader.ok());
  OrbConfig config;
  config.Read(*reader);
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(config.features, 1200);
  EXPECT_EQ(config.min_fast_threshold, 5);
  for (const char* text : {"features: 99", "levels: 13", "scale_factor: 1.0", "min_fast_threshold: 21"}) {
    auto bad = ConfigReader::FromText(text, "test");
    ASSERT_TRUE(bad.ok());
    OrbConfig ignored;
    ignored.Read(*bad);
    EXPECT_FALSE(bad->Finish().ok()) << text;
  }
}

}  // namespace
}  // namespace semmap
