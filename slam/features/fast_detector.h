#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slam/features/corner.h"

namespace semmap {

// FAST corners (Rosten and Drummond, ECCV 2006; 9 of 16 on a circle of radius 3) whose score is a local
// maximum among its eight neighbours. Every pixel is scored by the largest threshold at which it is a corner,
// many pixels at a time. Keeps its buffers between calls. Not thread-safe. Deterministic, also across CPUs.
class FastDetector {
 public:
  // Rows and columns around the region to search that the circle needs.
  static constexpr int kCircleRadius = 3;
  // Vector loads may read this many bytes past a row's last pixel.
  static constexpr int kOverread = 64;

  // Fills `corners`, row by row, with those of score above `threshold` in `region`, which keeps kCircleRadius
  // away from the borders of `image` (CV_8UC1, kOverread readable bytes after each row).
  void Detect(const cv::Mat& image, const cv::Rect& region, int threshold, std::vector<Corner>* corners);

 private:
  void ScoreRow(const uint8_t* row, ptrdiff_t step, int count, int threshold, uint8_t* scores) const;

  std::vector<uint8_t> scores_;  // three rows, used in turn
};

}  // namespace semmap
