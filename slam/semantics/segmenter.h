#pragma once

#include <memory>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "slam/semantics/segmentation.h"

namespace semmap {

// Says what the pixels of images show. slam/semantics/torch has the one that runs a network. Thread-safe.
class Segmenter {
 public:
  virtual ~Segmenter() = default;

  // One segmentation for each image (CV_8UC3 BGR or CV_8UC1, of any size, not empty), in order. Images that
  // the network sees at one size go through it as one batch. INVALID_ARGUMENT for other pixels, INTERNAL when
  // the network fails or its scores are not numbers.
  virtual absl::StatusOr<std::vector<Segmentation>> Segment(std::span<const cv::Mat> images) = 0;
};

}  // namespace semmap
