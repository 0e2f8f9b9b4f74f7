#include "slam/features/image_pyramid.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

TEST(Downscaler, AgreesWithBilinearInterpolation) {
  for (const double factor : {1.0, 1.05, 1.2, 1.5, 1.99, 2.0}) {
    for (const cv::Size from : {cv::Size(321, 123), cv::Size(66, 65), cv::Size(17, 200)}) {
      const cv::Size to(static_cast<int>(std::lround(from.width / factor)),
                        static_cast<int>(std::lround(from.height / factor)));
      const cv::Mat image = test::TexturedImage(from, 61);
      cv::Mat expected;
      cv::resize(image, expected, to, 0, 0, cv::INTER_LINEAR);
      cv::Mat scaled(to, CV_8UC1);
      Downscaler(from, to).Scale(image, &scaled);
      // Weights are multiples of 1/64, so that contrast 255 may err by 2 + rounding.
      EXPECT_LE(cv::norm(expected, scaled, cv::NORM_INF), 4) << factor << from;
      EXPECT_LT(cv::norm(expected, scaled, cv::NORM_L1) / to.area(), 0.6) << factor << from;
    }
  }
}

TEST(Downscaler, TinyAndFlatImages) {
  cv::Mat one(1, 1, CV_8UC1, cv::Scalar(77));
  cv::Mat result(1, 1, CV_8UC1);
  Downscaler({1, 1}, {1, 1}).Scale(one, &result);
  EXPECT_EQ(result.at<uint8_t>(0, 0), 77);
  const cv::Mat white(50, 31, CV_8UC1, cv::Scalar(255));
  cv::Mat scaled(40, 26, CV_8UC1);
  Downscaler(white.size(), scaled.size()).Scale(white, &scaled);
  EXPECT_EQ(cv::countNonZero(scaled != 255), 0);
}

TEST(ImagePyramid, SizesFallByTheFactorAndPlacesStay) {
  // A Gaussian blob has the same centre, in units of the image's size, on all levels.
  cv::Mat image(240, 320, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(
          250 * std::exp(-((x - 200.3) * (x - 200.3) + (y - 90.6) * (y - 90.6)) / (2 * 18.0 * 18.0)));
    }
  }
  ImagePyramid pyramid(8, 1.2);
  pyramid.Build(image);
  ASSERT_EQ(pyramid.levels().size(), 8u);
  for (int level = 0; level < 8; ++level) {
    const cv::Mat& scaled = pyramid.levels()[level];
    EXPECT_EQ(scaled.cols, std::lround(320 / std::pow(1.2, level)));
    EXPECT_EQ(scaled.rows, std::lround(240 / std::pow(1.2, level)));
    const cv::Moments moments = cv::moments(scaled);
    EXPECT_NEAR((moments.m10 / moments.m00 + 0.5) * 320 / scaled.cols - 0.5, 200.3, 0.1) << level;
    EXPECT_NEAR((moments.m01 / moments.m00 + 0.5) * 240 / scaled.rows - 0.5, 90.6, 0.1) << level;
  }
}

TEST(ImagePyramid, SurvivesChangesOfSize) {
  ImagePyramid pyramid(12, 2.0);
  for (const cv::Size size : {cv::Size(64, 64), cv::Size(200, 100), cv::Size(64, 64)}) {
    const cv::Mat image = test::TexturedImage(size, 62);
    pyramid.Build(image);
    EXPECT_EQ(pyramid.levels()[0].size(), size);
    EXPECT_EQ(cv::norm(pyramid.levels()[0], image, cv::NORM_INF), 0);
    EXPECT_GE(pyramid.levels()[11].cols, 1);
  }
  pyramid.Clear();
  EXPECT_TRUE(pyramid.levels()[0].empty());
}

}  // namespace
}  // namespace semmap
