#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
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

  // Corners of score above `threshold` in `region`, row by row; valid until the next call. The region keeps
  // kCircleRadius away from the borders of `image`, which is padded (padded_image.h).
  std::span<const Corner> Detect(const cv::Mat& image, const cv::Rect& region, int threshold);

  // Where between the pixels the score of a corner of the last Detect has its maximum: from the corner, at
  // most half a pixel in x and in y; a parabola through the scores of neighbours.
  cv::Point2f SubPixelOffset(const Corner& corner) const;

 private:
  void LayOut(const cv::Rect& region);
  void AppendMaxima(int y, int threshold);
  uint8_t* ScoreRowOf(int y) {
    return scores_.data() + static_cast<ptrdiff_t>(y - region_.y + 1) * row_bytes_ + kLead;
  }

  // Bytes before each row of scores; the last is zero, the left neighbour of the first pixel.
  static constexpr int kLead = 64;

  cv::Rect region_;
  ptrdiff_t row_bytes_ = 0;
  // What the scores of the region exceed the threshold by, within a frame of zeros.
  std::vector<uint8_t> scores_;
  // The first corner_count_ count.
  std::vector<Corner> corners_;
  size_t corner_count_ = 0;
};

}  // namespace semmap
