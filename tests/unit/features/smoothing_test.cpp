#include "slam/features/smoothing.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "slam/features/padded_image.h"
#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

cv::Mat Padded(const cv::Mat& image) {
  cv::Mat padded = MakePaddedImage(image.size());
  image.copyTo(padded);
  return padded;
}

TEST(Smoother, AgreesWithItsKernel) {
  const cv::Mat kernel = (cv::Mat_<float>(1, 7) << 1, 2, 3, 4, 3, 2, 1) / 16.0F;
  Smoother smoother;
  for (const cv::Size size : {cv::Size(300, 120), cv::Size(65, 67), cv::Size(5, 4), cv::Size(4, 90)}) {
    const cv::Mat image = test::TexturedImage(size, 51);
    cv::Mat expected;
    cv::sepFilter2D(image, expected, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REFLECT_101);
    cv::Mat smooth = MakePaddedImage(size);
    smoother.Smooth(Padded(image), &smooth);
    // Four averages in a row a side, each of which rounds up by at most a half.
    cv::Mat difference;
    cv::subtract(smooth, expected, difference, {}, CV_32F);
    double least = 0;
    double most = 0;
    cv::minMaxLoc(difference, &least, &most);
    EXPECT_GE(least, -0.01) << size;
    EXPECT_LE(most, 4.01) << size;
  }
}

TEST(Smoother, FlatImagesStayAsTheyAre) {
  for (const int value : {0, 1, 128, 255}) {
    const cv::Mat image = Padded(cv::Mat(40, 50, CV_8UC1, cv::Scalar(value)));
    cv::Mat smooth = MakePaddedImage(image.size());
    Smoother().Smooth(image, &smooth);
    EXPECT_EQ(cv::norm(image, smooth, cv::NORM_INF), 0) << value;
  }
}

}  // namespace
}  // namespace semmap
