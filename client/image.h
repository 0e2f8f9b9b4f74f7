#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "semmap/v1/frame.pb.h"

namespace semmap::client {

// The bytes of a JPEG or PNG file, told apart by their first bytes and otherwise not looked at;
// INVALID_ARGUMENT for anything else.
absl::StatusOr<v1::Image> FileImage(std::string file_bytes);

// Pixels as they are: CV_8UC1 (grey, class masks), CV_8UC3 (BGR), CV_16UC1 and CV_32FC1 (depth). Makes a
// copy. INVALID_ARGUMENT for other types and empty images.
absl::StatusOr<v1::Image> RawImage(const cv::Mat& pixels);

// Lossless: CV_8UC1, CV_8UC3, CV_16UC1.
absl::StatusOr<v1::Image> PngImage(const cv::Mat& pixels);

// CV_8UC1 or CV_8UC3; quality 1 to 100.
absl::StatusOr<v1::Image> JpegImage(const cv::Mat& pixels, int quality);

}  // namespace semmap::client
