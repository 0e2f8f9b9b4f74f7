#pragma once

#include <cstdint>
#include <fstream>
#include <string_view>

#include "absl/status/status.h"
#include "server/artifacts.h"

namespace semmap::server {

// Writes the bytes of a pending file one after the other. Errors: FILES_TOO_LARGE, and STORE_UNAVAILABLE when
// the disk does not take them. Not thread-safe.
class OutputFile {
 public:
  // `file` outlives this.
  explicit OutputFile(PendingFile* file);

  absl::Status Append(std::string_view bytes);
  // Writes over the first bytes, which must be there.
  absl::Status ReplaceBeginning(std::string_view bytes);
  // All bytes are in the file. Last call.
  absl::Status Close();

  int64_t size() const { return size_; }

 private:
  PendingFile* const file_;
  std::ofstream stream_;
  int64_t size_ = 0;
  int64_t reserved_ = 0;
};

}  // namespace semmap::server
