#pragma once

#include <string>

#include <opencv2/core.hpp>

#include "absl/status/status.h"

namespace semmap::client {

// Whatever the file's name ends in. UNAVAILABLE when it cannot be written.
absl::Status WritePng(const std::string& path, const cv::Mat& picture);

}  // namespace semmap::client
