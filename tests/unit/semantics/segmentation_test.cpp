#include "slam/semantics/segmentation.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace semmap {
namespace {

std::shared_ptr<const std::vector<uint8_t>> Classes(std::vector<uint8_t> ids) {
  return std::make_shared<const std::vector<uint8_t>>(std::move(ids));
}

int ConfidenceOf(double probability) { return static_cast<int>(std::lround(255 * probability)); }

TEST(Segmentation, OneCellIsTheWholeImage) {
  const Segmentation segmentation({40, 30}, {1, 1}, {1.0F, 3.0F}, Classes({7, 13}));
  for (const float x : {-5.0F, 0.0F, 20.5F, 39.0F, 100.0F}) {
    EXPECT_EQ(segmentation.At(x, 12).semantic_class, 13);
    EXPECT_EQ(segmentation.At(x, 12).confidence, ConfidenceOf(1 / (1 + std::exp(-2.0))));
  }
}

// Two cells over eight pixels have their centres at 1.5 and 5.5; half way the scores are equal.
TEST(Segmentation, InterpolatesBetweenTheCentresOfCells) {
  const Segmentation segmentation({8, 4}, {2, 1}, {4, 0, /* second channel */ 0, 4}, Classes({1, 2}));
  EXPECT_EQ(segmentation.At(3.4F, 2).semantic_class, 1);
  EXPECT_EQ(segmentation.At(3.6F, 2).semantic_class, 2);
  EXPECT_EQ(segmentation.At(0, 2).confidence, segmentation.At(1.5F, 2).confidence);
  EXPECT_EQ(segmentation.At(1.5F, 2).confidence, ConfidenceOf(1 / (1 + std::exp(-4.0))));
  // A quarter of the way: scores 3 and 1.
  EXPECT_EQ(segmentation.At(2.5F, 2).confidence, ConfidenceOf(1 / (1 + std::exp(-2.0))));
}

TEST(Segmentation, RowsAreInterpolatedLikeColumns) {
  const Segmentation segmentation({4, 8}, {1, 2}, {4, 0, 0, 4}, Classes({1, 2}));
  EXPECT_EQ(segmentation.At(2, 3.4F).semantic_class, 1);
  EXPECT_EQ(segmentation.At(2, 3.6F).semantic_class, 2);
}

TEST(Segmentation, ChannelsOfOneClassAddTheirProbabilities) {
  const Segmentation segmentation({2, 2}, {1, 1}, {2, 2, 2, 0}, Classes({4, 10, 4, kUnknownClass}));
  EXPECT_EQ(segmentation.At(0, 0).semantic_class, 4);
  EXPECT_EQ(segmentation.At(0, 0).confidence, ConfidenceOf(2 / (3 + std::exp(-2.0))));
}

TEST(Segmentation, AChannelWithoutClassMeansNoClass) {
  const Segmentation segmentation({2, 2}, {1, 1}, {0, 2}, Classes({4, kUnknownClass}));
  EXPECT_EQ(segmentation.At(1, 1).semantic_class, kUnknownClass);
}

// Two implementations of one definition: keypoint by keypoint, and for the whole image.
TEST(Segmentation, MasksSayWhatAtSays) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal(0, 3);
  constexpr int kChannels = 5;
  const cv::Size image(53, 31);
  const cv::Size grid(16, 8);
  std::vector<float> scores(kChannels * static_cast<size_t>(grid.area()));
  for (float& score : scores) score = normal(random);
  const Segmentation segmentation(image, grid, scores, Classes({1, 7, 9, 10, 13}));
  cv::Mat classes;
  cv::Mat confidences;
  segmentation.ToMasks(&classes, &confidences);
  cv::Mat without_confidences;
  segmentation.ToMasks(&without_confidences, nullptr);
  ASSERT_EQ(classes.size(), image);
  EXPECT_EQ(cv::norm(classes, without_confidences, cv::NORM_INF), 0);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const PixelClass pixel = segmentation.At(static_cast<float>(x), static_cast<float>(y));
      EXPECT_NEAR(pixel.confidence, confidences.at<uint8_t>(y, x), 1) << x << " " << y;
      // Below one half two classes may be equal but for rounding.
      if (pixel.confidence <= 128) continue;
      EXPECT_EQ(pixel.semantic_class, classes.at<uint8_t>(y, x)) << x << " " << y;
    }
  }
}

}  // namespace
}  // namespace semmap
