#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace semmap {

// The smoothing that the tests of BRIEF read: 7 x 7 pixels, weights 1 2 3 4 3 2 1 along either side, close to
// a Gaussian with a standard deviation of 2; the image is mirrored at its borders. Made of averages of two
// bytes, which CPUs take of many at once; each rounds up, so that the result is about two grey levels bright.
// Keeps its buffer between calls. Not thread-safe. Deterministic across CPUs.
class Smoother {
 public:
  static constexpr int kRadius = 3;

  // Both images are padded (padded_image.h), of one size, at least kRadius + 1 pixels a side, and do not
  // overlap.
  void Smooth(const cv::Mat& image, cv::Mat* smooth);

 private:
  std::vector<uint8_t> row_;
};

}  // namespace semmap
