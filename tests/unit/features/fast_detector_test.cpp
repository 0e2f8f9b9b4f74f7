#include "slam/features/fast_detector.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "slam/features/padded_image.h"
#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

// The definition, one pixel at a time.
int ScoreByDefinition(const cv::Mat& image, int x, int y) {
  constexpr int kX[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
  constexpr int kY[16] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
  const int centre = image.at<uint8_t>(y, x);
  int best = 0;
  for (int first = 0; first < 16; ++first) {
    int least_brighter = 255;
    int least_darker = 255;
    for (int i = first; i < first + 9; ++i) {
      const int pixel = image.at<uint8_t>(y + kY[i % 16], x + kX[i % 16]);
      least_brighter = std::min(least_brighter, pixel - centre);
      least_darker = std::min(least_darker, centre - pixel);
    }
    best = std::max({best, least_brighter, least_darker});
  }
  return best;
}

std::vector<Corner> CornersByDefinition(const cv::Mat& image, const cv::Rect& region, int threshold) {
  const auto score = [&](int x, int y) {
    return region.contains({x, y}) ? ScoreByDefinition(image, x, y) : 0;
  };
  std::vector<Corner> corners;
  for (int y = region.y; y < region.br().y; ++y) {
    for (int x = region.x; x < region.br().x; ++x) {
      const int own = score(x, y);
      if (own <= threshold) continue;
      const int before =
          std::max({score(x - 1, y - 1), score(x, y - 1), score(x + 1, y - 1), score(x - 1, y)});
      const int after =
          std::max({score(x - 1, y + 1), score(x, y + 1), score(x + 1, y + 1), score(x + 1, y)});
      if (own > before && own >= after) {
        corners.push_back({static_cast<uint16_t>(x), static_cast<uint16_t>(y), static_cast<uint8_t>(own)});
      }
    }
  }
  return corners;
}

// `image` with bytes after each row that a vector may read; filled with what would change the result if it
// counted.
cv::Mat WithSlack(const cv::Mat& image, uint8_t slack) {
  cv::Mat buffer(image.rows + 1, image.cols + kImagePadding, CV_8UC1, cv::Scalar(slack));
  cv::Mat window = buffer(cv::Rect({0, 0}, image.size()));
  image.copyTo(window);
  return window;
}

std::vector<Corner> Detect(FastDetector* detector, const cv::Mat& image, const cv::Rect& region,
                           int threshold) {
  const auto corners = detector->Detect(image, region, threshold);
  return {corners.begin(), corners.end()};
}

TEST(FastDetector, FindsWhatTheDefinitionSays) {
  FastDetector detector;
  std::vector<Corner> corners;
  for (const cv::Size size : {cv::Size(200, 90), cv::Size(71, 65), cv::Size(67, 40), cv::Size(133, 64)}) {
    const cv::Mat image = test::TexturedImage(size, static_cast<uint64_t>(size.width));
    for (const int threshold : {1, 7, 20, 60}) {
      for (const cv::Rect& region :
           {cv::Rect(3, 3, size.width - 6, size.height - 6), cv::Rect(17, 11, 40, 9)}) {
        const auto expected = CornersByDefinition(image, region, threshold);
        for (const uint8_t slack : {uint8_t{0}, uint8_t{255}}) {
          corners = Detect(&detector, WithSlack(image, slack), region, threshold);
          ASSERT_EQ(corners, expected) << size << " " << threshold << " " << region;
        }
      }
    }
    EXPECT_GT(corners.size() + CornersByDefinition(image, {3, 3, 50, 30}, 7).size(), 10u);
  }
}

TEST(FastDetector, SaturatedContrast) {
  cv::Mat image = cv::Mat::zeros(64, 64, CV_8UC1);
  image.at<uint8_t>(30, 30) = 255;
  FastDetector detector;
  const auto corners = Detect(&detector, WithSlack(image, 0), {3, 3, 58, 58}, 20);
  ASSERT_EQ(corners.size(), 1u);
  EXPECT_EQ(corners[0], (Corner{30, 30, 255}));
}

TEST(FastDetector, SubPixelOffsetFollowsTheNeighboursScores) {
  const cv::Mat image = WithSlack(test::TexturedImage({150, 90}, 4), 0);
  const cv::Rect region(5, 4, 131, 77);
  constexpr int kThreshold = 12;
  FastDetector detector;
  const auto corners = Detect(&detector, image, region, kThreshold);
  ASSERT_GT(corners.size(), 50u);
  const auto excess = [&](int x, int y) {
    return region.contains({x, y}) ? std::max(0, ScoreByDefinition(image, x, y) - kThreshold) : 0;
  };
  const auto vertex = [](double before, double middle, double after) {
    return middle == before && middle == after ? 0 : (after - before) / (2 * (2 * middle - before - after));
  };
  for (const Corner& corner : corners) {
    const int x = corner.x;
    const int y = corner.y;
    const cv::Point2f offset = detector.SubPixelOffset(corner);
    EXPECT_NEAR(offset.x, vertex(excess(x - 1, y), excess(x, y), excess(x + 1, y)), 1e-6);
    EXPECT_NEAR(offset.y, vertex(excess(x, y - 1), excess(x, y), excess(x, y + 1)), 1e-6);
    EXPECT_LE(std::max(std::abs(offset.x), std::abs(offset.y)), 0.5F);
  }
}

TEST(FastDetector, EmptyRegion) {
  FastDetector detector;
  const cv::Mat image = WithSlack(test::TexturedImage({64, 64}, 1), 0);
  EXPECT_FALSE(Detect(&detector, image, {10, 10, 40, 40}, 7).empty());
  EXPECT_TRUE(Detect(&detector, image, {10, 10, 0, 5}, 7).empty());
}

}  // namespace
}  // namespace semmap
