#pragma once

#include <string_view>

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"

namespace semmap::server {

// Decodes a JPEG file to grey (CV_8UC1) that must be `size` large, which is checked before any pixel is
// decoded. libjpeg repairs what it can; for a map that is worse than no image, so every warning of it (data
// missing, bad codes, stray bytes) counts as damage. Errors: OUT_OF_RANGE for another size, DATA_LOSS for a
// damaged file, UNIMPLEMENTED for one that is not grey, YCbCr or RGB.
absl::StatusOr<cv::Mat> DecodeJpegGrey(std::string_view file, cv::Size size);

struct JpegImage {
  cv::Mat grey;    // CV_8UC1, what DecodeJpegGrey gives
  cv::Mat colour;  // CV_8UC3 BGR; `grey` itself when the file is grey
};

// The same with the colours, for little more than the time of one.
absl::StatusOr<JpegImage> DecodeJpegColour(std::string_view file, cv::Size size);

}  // namespace semmap::server
