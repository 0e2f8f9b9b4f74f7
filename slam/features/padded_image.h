#pragma once

#include <opencv2/core/mat.hpp>

namespace semmap {

// Bytes after each row of a padded image that may be read and written: vectors run past the last pixel.
constexpr int kImagePadding = 64;

// A black CV_8UC1 image with padding.
inline cv::Mat MakePaddedImage(const cv::Size& size) {
  constexpr int kAlignment = 64;
  const int step = (size.width + kAlignment - 1) / kAlignment * kAlignment + kImagePadding;
  return cv::Mat::zeros(size.height + 1, step, CV_8UC1)(cv::Rect({0, 0}, size));
}

}  // namespace semmap
