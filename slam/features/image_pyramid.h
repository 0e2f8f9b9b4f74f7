#pragma once

#include <cstddef>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slam/features/downscale.h"

namespace semmap {

// An image and its ever smaller copies. Rows of every level lie equally far apart, so that one table of byte
// offsets serves all, and kSlack bytes after each row may be read. Reuses its memory for images of the same
// size. Not thread-safe.
class ImagePyramid {
 public:
  ImagePyramid(int levels, double scale_factor) : scale_factor_(scale_factor), levels_(levels) {}

  // Copies `grey` (CV_8UC1) and scales it down.
  void Build(const cv::Mat& grey);
  // Forgets the image, as if nothing had been built.
  void Clear();

  const std::vector<cv::Mat>& levels() const { return levels_; }

 private:
  void Allocate(const cv::Size& size);

  double scale_factor_;
  std::vector<cv::Mat> levels_;  // each padded
  std::vector<Downscaler> downscalers_;
};

}  // namespace semmap
