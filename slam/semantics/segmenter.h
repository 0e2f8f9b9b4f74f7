#pragma once

#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"

namespace semmap {

// What an image shows, pixel by pixel.
struct Segmentation {
  cv::Mat classes;     // CV_8UC1, ids of SemanticClass, as large as the image
  cv::Mat confidence;  // CV_8UC1, probability of the class, 255 = certain; may be empty: all certain
};

// Tells the class of each pixel. One serves all sessions: thread-safe.
class Segmenter {
 public:
  virtual ~Segmenter() = default;

  // One answer for each image, in their order. Images are CV_8UC3 (BGR) or CV_8UC1, and need not be of one
  // size.
  virtual absl::StatusOr<std::vector<Segmentation>> Segment(std::span<const cv::Mat> images) = 0;
};

}  // namespace semmap
