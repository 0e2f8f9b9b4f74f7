#include "slam/features/image_pyramid.h"

#include <algorithm>
#include <cmath>

namespace semmap {
namespace {

constexpr int kRowAlignment = 64;

// A window of `size` into memory with slack, which is zero so that one run is like the other.
cv::Mat AllocateLevel(const cv::Size& size) {
  const int step = (size.width + kRowAlignment - 1) / kRowAlignment * kRowAlignment + ImagePyramid::kSlack;
  return cv::Mat::zeros(size.height + 1, step, CV_8UC1)(cv::Rect({0, 0}, size));
}

}  // namespace

void ImagePyramid::Allocate(const cv::Size& size) {
  downscalers_.clear();
  for (size_t level = 0; level < levels_.size(); ++level) {
    const double scale = std::pow(scale_factor_, level);
    const cv::Size level_size(std::max(1, static_cast<int>(std::lround(size.width / scale))),
                              std::max(1, static_cast<int>(std::lround(size.height / scale))));
    levels_[level] = AllocateLevel(level_size);
    if (level > 0) downscalers_.emplace_back(levels_[level - 1].size(), level_size);
  }
}

void ImagePyramid::Build(const cv::Mat& grey) {
  if (levels_[0].size() != grey.size()) Allocate(grey.size());
  grey.copyTo(levels_[0]);
  for (size_t level = 1; level < levels_.size(); ++level) {
    downscalers_[level - 1].Scale(levels_[level - 1], &levels_[level]);
  }
}

void ImagePyramid::Clear() { std::fill(levels_.begin(), levels_.end(), cv::Mat()); }

}  // namespace semmap
