#pragma once

#include <string_view>

#include "absl/status/statusor.h"

namespace semmap::server {

// What the first chunk of a PNG file says.
struct PngHeader {
  int64_t width = 0;
  int64_t height = 0;
  int bit_depth = 0;
  bool grey = false;  // one channel, no palette, no transparency
};

// Walks over the whole file: signature, header, the checksum of every chunk, the end chunk as the last one.
// DATA_LOSS for a file that is truncated or damaged; decodes no pixel.
absl::StatusOr<PngHeader> CheckPngFile(std::string_view file);

}  // namespace semmap::server
