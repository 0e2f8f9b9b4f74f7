#include "client/cli/write_png.h"

#include <fstream>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"

namespace semmap::client {

absl::Status WritePng(const std::string& path, const cv::Mat& picture) {
  std::vector<uint8_t> bytes;
  // Encoded to memory first, so that the name of the file need not end in .png.
  if (!cv::imencode(".png", picture, bytes)) return absl::InternalError("the picture cannot be encoded");
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) return absl::UnavailableError(absl::StrCat(path, ": cannot be written"));
  return absl::OkStatus();
}

}  // namespace semmap::client
