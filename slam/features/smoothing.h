#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace semmap {

// Gaussian smoothing over 7 x 7 pixels with a standard deviation of 2, in 8-bit fixed point, the image
// mirrored at its borders: what the tests of BRIEF read. Keeps its buffer between calls. Not thread-safe.
// Deterministic across CPUs.
class Smoother {
 public:
  static constexpr int kRadius = 3;

  // `smooth` has the size and type (CV_8UC1) of `image`, at least kRadius + 1 pixels a side, and does not
  // overlap it.
  void Smooth(const cv::Mat& image, cv::Mat* smooth);

 private:
  std::vector<uint8_t> row_;
};

}  // namespace semmap
