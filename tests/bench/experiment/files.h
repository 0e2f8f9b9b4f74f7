#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"

namespace semmap::bench {

bool FileExists(const std::string& path);
absl::Status MakeFolders(const std::string& path);
// The file appears whole or not at all.
absl::Status WriteJson(const std::string& path, const nlohmann::json& json);
absl::StatusOr<nlohmann::json> ReadJson(const std::string& path);
// As the extension says; `parameters` are OpenCV's.
absl::Status WriteImage(const std::string& path, const cv::Mat& image, const std::vector<int>& parameters);
absl::StatusOr<cv::Mat> ReadImageFile(const std::string& path, int flags);

}  // namespace semmap::bench
