#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"

namespace semmap::client {

enum class ImageEncoding { kNone, kJpeg, kPng };

// An image as a source has it: the bytes of a JPEG or PNG file, which can be sent as they are, or else
// pixels.
struct SourceImage {
  std::string path;  // the file it came from; empty for frames of a video
  ImageEncoding encoding = ImageEncoding::kNone;
  std::string encoded;  // the file's bytes, unless encoding is kNone
  cv::Mat pixels;       // CV_8UC1 or CV_8UC3 (BGR); depth: CV_16UC1; when encoding is kNone

  bool empty() const { return encoded.empty() && pixels.empty(); }
};

constexpr size_t kMaxImageBytes = size_t{64} << 20;

// Reads a file. JPEG and PNG stay encoded (not even looked into); other formats that OpenCV knows are
// decoded, to grey unless `is_depth`. NOT_FOUND, RESOURCE_EXHAUSTED beyond kMaxImageBytes, INVALID_ARGUMENT
// for no image.
absl::StatusOr<SourceImage> ReadSourceImage(const std::string& path, bool is_depth);

// Pixels as CV_8UC1; colour becomes grey. INVALID_ARGUMENT when the bytes are no image.
absl::StatusOr<cv::Mat> DecodeGray(const SourceImage& image);
// Pixels as CV_8UC3 (BGR); grey becomes three equal channels. INVALID_ARGUMENT when the bytes are no image.
absl::StatusOr<cv::Mat> DecodeColour(const SourceImage& image);
// Pixels as CV_16UC1. INVALID_ARGUMENT when the image is of another kind.
absl::StatusOr<cv::Mat> DecodeDepth(const SourceImage& image);

// Class ids as CV_8UC1. INVALID_ARGUMENT also for JPEG, which would mix the ids of neighbours, and for
// colour.
absl::StatusOr<cv::Mat> DecodeClasses(const SourceImage& image);

// Width and height of an image file.
absl::StatusOr<cv::Size> ImageSizeOf(const std::string& path);

}  // namespace semmap::client
