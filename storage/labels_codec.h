#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "storage/byte_buffer.h"

// The packed form of a map's labels: a format byte (1), then key and value of each, every text with its
// length (varint) before it, in order of keys.
namespace semmap::storage {

Blob EncodeLabels(const std::map<std::string, std::string>& labels);
// DATA_LOSS for anything that EncodeLabels did not write.
absl::StatusOr<std::map<std::string, std::string>> DecodeLabels(BlobView bytes);

}  // namespace semmap::storage
