#include "slam/features/patch_orientation.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

float AngleAt(const cv::Mat& image, int x, int y) {
  return IntensityCentroidAngle(image.ptr(y, x), static_cast<ptrdiff_t>(image.step[0]));
}

double AngleByDefinition(const cv::Mat& image, int x, int y) {
  double moment_x = 0;
  double moment_y = 0;
  for (int dy = -15; dy <= 15; ++dy) {
    for (int dx = -15; dx <= 15; ++dx) {
      if (dx * dx + dy * dy > 15.5 * 15.5) continue;
      moment_x += dx * image.at<uint8_t>(y + dy, x + dx);
      moment_y += dy * image.at<uint8_t>(y + dy, x + dx);
    }
  }
  return std::atan2(moment_y, moment_x);
}

TEST(PatchOrientation, AgreesWithTheDefinition) {
  const cv::Mat image = test::TexturedImage({300, 200}, 31);
  for (int y = 16; y < 184; y += 7) {
    for (int x = 16; x < 284; x += 11) {
      const double difference = AngleAt(image, x, y) - AngleByDefinition(image, x, y);
      ASSERT_NEAR(std::remainder(difference, 2 * std::numbers::pi), 0, 1e-5) << x << " " << y;
    }
  }
}

TEST(PatchOrientation, PointsToTheBrightSide) {
  // Full contrast: the sums reach their largest values.
  for (int quarter = 0; quarter < 4; ++quarter) {
    cv::Mat image = cv::Mat::zeros(41, 41, CV_8UC1);
    const cv::Rect halves[4] = {{21, 0, 20, 41}, {0, 21, 41, 20}, {0, 0, 20, 41}, {0, 0, 41, 20}};
    image(halves[quarter]).setTo(255);
    EXPECT_NEAR(AngleAt(image, 20, 20), quarter * std::numbers::pi / 2, 1e-6);
  }
}

TEST(PatchOrientation, FlatPatchHasAngleZero) {
  EXPECT_EQ(AngleAt(cv::Mat(41, 41, CV_8UC1, cv::Scalar(200)), 20, 20), 0);
}

}  // namespace
}  // namespace semmap
