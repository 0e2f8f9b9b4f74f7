#pragma once

#include <cstdint>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace semmap::test {

// An image full of corners at every scale: grey rectangles of random place, size and turn, slightly smoothed
// as a lens would. The same for a seed on every run.
inline cv::Mat TexturedImage(const cv::Size& size, uint64_t seed) {
  cv::RNG random(seed);
  cv::Mat image(size, CV_8UC1, cv::Scalar(128));
  const int shapes = size.area() / 60;
  for (int i = 0; i < shapes; ++i) {
    const cv::Point2f centre(random.uniform(0.0F, static_cast<float>(size.width)),
                             random.uniform(0.0F, static_cast<float>(size.height)));
    const float longest = 60.0F * (1.0F - static_cast<float>(i) / static_cast<float>(shapes)) + 8.0F;
    const cv::RotatedRect rectangle(centre, {random.uniform(4.0F, longest), random.uniform(4.0F, longest)},
                                    random.uniform(0.0F, 90.0F));
    cv::Point2f corners[4];
    rectangle.points(corners);
    cv::Point polygon[4];
    for (int k = 0; k < 4; ++k) polygon[k] = cv::Point(cvRound(corners[k].x), cvRound(corners[k].y));
    cv::fillConvexPoly(image, polygon, 4, cv::Scalar(random.uniform(20, 236)), cv::LINE_AA);
  }
  cv::GaussianBlur(image, image, {5, 5}, 0.8);
  return image;
}

}  // namespace semmap::test
