#include "slam/features/smoothing.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

TEST(Smoother, AgreesWithAGaussianToAGreyLevel) {
  Smoother smoother;
  for (const cv::Size size : {cv::Size(300, 120), cv::Size(65, 67), cv::Size(5, 4), cv::Size(4, 90)}) {
    const cv::Mat image = test::TexturedImage(size, 51);
    cv::Mat expected;
    cv::GaussianBlur(image, expected, {7, 7}, 2, 2, cv::BORDER_REFLECT_101);
    cv::Mat smooth(size, CV_8UC1);
    smoother.Smooth(image, &smooth);
    EXPECT_LE(cv::norm(expected, smooth, cv::NORM_INF), 2) << size;
    EXPECT_LT(cv::norm(expected, smooth, cv::NORM_L1) / size.area(), 0.6) << size;
  }
}

TEST(Smoother, FlatImagesStayAsTheyAre) {
  for (const int value : {0, 1, 128, 255}) {
    const cv::Mat image(40, 50, CV_8UC1, cv::Scalar(value));
    cv::Mat smooth(image.size(), CV_8UC1);
    Smoother().Smooth(image, &smooth);
    EXPECT_EQ(cv::norm(image, smooth, cv::NORM_INF), 0) << value;
  }
}

}  // namespace
}  // namespace semmap
