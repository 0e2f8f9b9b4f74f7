#pragma once

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "semmap/v1/frame.pb.h"

namespace semmap::server {

enum class ImageRole {
  kGrey,       // to CV_8UC1
  kDepth,      // to CV_16UC1 in the rig's units, or CV_32FC1 metres (not finite: 0)
  kClassMask,  // to CV_8UC1
};

// Decodes an image that must be `size` large, and checks that it is whole. Sizes are compared before pixels
// are decoded, so a small file cannot ask for a large allocation. Errors by reason:
// IMAGE_ENCODING_UNSUPPORTED, IMAGE_SIZE_MISMATCH, IMAGE_CORRUPT; `field` and `sequence` go into their
// metadata. Thread-safe.
absl::StatusOr<cv::Mat> DecodeImage(const v1::Image& image, ImageRole role, cv::Size size, const char* field,
                                    uint64_t sequence);

struct ColourImage {
  cv::Mat grey;    // CV_8UC1; the same as for ImageRole::kGrey
  cv::Mat colour;  // CV_8UC3 BGR; `grey` itself when the image has no colours
};

// The same for an image of ImageRole::kGrey whose colours are wanted, too.
absl::StatusOr<ColourImage> DecodeColourImage(const v1::Image& image, cv::Size size, const char* field,
                                              uint64_t sequence);

}  // namespace semmap::server
