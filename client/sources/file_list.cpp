#include "client/sources/file_list.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace semmap::client {
namespace {

bool IsDigit(char c) { return absl::ascii_isdigit(static_cast<unsigned char>(c)); }

// The run of digits at the front, without leading zeros; removed from `text`.
absl::string_view TakeNumber(absl::string_view* text) {
  size_t length = 0;
  while (length < text->size() && IsDigit((*text)[length])) ++length;
  absl::string_view number = text->substr(0, length);
  text->remove_prefix(length);
  while (number.size() > 1 && number.front() == '0') number.remove_prefix(1);
  return number;
}

bool IsImageName(const std::filesystem::path& path) {
  static const std::set<std::string> extensions = {".jpg", ".jpeg", ".png", ".bmp",
                                                   ".pgm", ".ppm",  ".tif", ".tiff"};
  return extensions.count(absl::AsciiStrToLower(path.extension().string())) > 0;
}

}  // namespace

bool NaturalLess(absl::string_view a, absl::string_view b) {
  const absl::string_view whole_a = a;
  const absl::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (IsDigit(a.front()) && IsDigit(b.front())) {
      const absl::string_view number_a = TakeNumber(&a);
      const absl::string_view number_b = TakeNumber(&b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
    } else if (a.front() != b.front()) {
      return a.front() < b.front();
    } else {
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  // Names that differ in leading zeros only still have an order.
  return a.empty() == b.empty() ? whole_a < whole_b : a.empty();
}

absl::StatusOr<std::vector<std::string>> ListImages(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> paths;
  for (auto entry = std::filesystem::directory_iterator(folder, error);
       !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    if (!IsImageName(entry->path()) || !entry->is_regular_file()) continue;
    if (paths.size() == kMaxFrames) {
      return absl::ResourceExhaustedError(absl::StrCat(folder, ": more than ", kMaxFrames, " images"));
    }
    paths.push_back(entry->path().string());
  }
  if (error) return absl::NotFoundError(absl::StrCat(folder, ": ", error.message()));
  if (paths.empty()) return absl::NotFoundError(absl::StrCat(folder, ": holds no images"));
  std::sort(paths.begin(), paths.end(),
            [](const std::string& a, const std::string& b) { return NaturalLess(a, b); });
  return paths;
}

bool FolderExists(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

bool FileExists(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}

std::string JoinPath(const std::string& folder, absl::string_view name) {
  return (std::filesystem::path(folder) / std::string(name)).string();
}

}  // namespace semmap::client
