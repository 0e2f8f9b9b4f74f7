#include "tests/bench/experiment/files.h"

#include <filesystem>
#include <fstream>
#include <system_error>

#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"

namespace semmap::bench {

namespace fs = std::filesystem;

bool FileExists(const std::string& path) {
  std::error_code error;
  return fs::exists(path, error);
}

absl::Status MakeFolders(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) return absl::InternalError(absl::StrCat("cannot make ", path, ": ", error.message()));
  return absl::OkStatus();
}

absl::Status WriteJson(const std::string& path, const nlohmann::json& json) {
  const std::string partial = path + ".part";
  {
    std::ofstream file(partial);
    file << json.dump(1) << "\n";
    if (!file.flush()) return absl::InternalError(absl::StrCat("cannot write ", partial));
  }
  std::error_code error;
  fs::rename(partial, path, error);
  if (error) return absl::InternalError(absl::StrCat("cannot write ", path, ": ", error.message()));
  return absl::OkStatus();
}

absl::StatusOr<nlohmann::json> ReadJson(const std::string& path) {
  std::ifstream file(path);
  if (!file) return absl::NotFoundError(absl::StrCat(path, ": no such file"));
  nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  if (json.is_discarded()) return absl::DataLossError(absl::StrCat(path, ": is not JSON"));
  return json;
}

absl::Status WriteImage(const std::string& path, const cv::Mat& image, const std::vector<int>& parameters) {
  try {
    if (cv::imwrite(path, image, parameters)) return absl::OkStatus();
    return absl::InternalError(absl::StrCat("cannot write ", path));
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("cannot write ", path, ": ", error.what()));
  }
}

absl::StatusOr<cv::Mat> ReadImageFile(const std::string& path, int flags) {
  try {
    cv::Mat image = cv::imread(path, flags);
    if (image.empty()) return absl::NotFoundError(absl::StrCat(path, ": no such image"));
    return image;
  } catch (const cv::Exception& error) {
    return absl::DataLossError(absl::StrCat(path, ": ", error.what()));
  }
}

}  // namespace semmap::bench
