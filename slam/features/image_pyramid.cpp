#include "slam/features/image_pyramid.h"

#include <algorithm>
#include <cmath>

#include "slam/features/padded_image.h"

namespace semmap {
void ImagePyramid::Allocate(const cv::Size& size) {
  downscalers_.clear();
  for (size_t level = 0; level < levels_.size(); ++level) {
    const double scale = std::pow(scale_factor_, level);
    const cv::Size level_size(std::max(1, static_cast<int>(std::lround(size.width / scale))),
                              std::max(1, static_cast<int>(std::lround(size.height / scale))));
    levels_[level] = MakePaddedImage(level_size);
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
