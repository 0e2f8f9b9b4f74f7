#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace semmap::client {

// No recording that one drive plays has more frames.
constexpr size_t kMaxFrames = 5'000'000;

// Runs of digits compare by value: "frame2" comes before "frame10".
bool NaturalLess(absl::string_view a, absl::string_view b);

// Paths of the image files (jpg, jpeg, png, bmp, pgm, ppm, tif, tiff) in a folder in natural order. NOT_FOUND
// when there is no such folder or no image in it.
absl::StatusOr<std::vector<std::string>> ListImages(const std::string& folder);

bool FolderExists(const std::string& path);
bool FileExists(const std::string& path);
// `folder` and `name` with one slash in between; an absolute name stays as it is.
std::string JoinPath(const std::string& folder, absl::string_view name);

}  // namespace semmap::client
