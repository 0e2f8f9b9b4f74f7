#pragma once

#include <string>

#include "absl/status/status.h"

namespace semmap::storage::sqlite {

// A database file that gets its name when it is complete; until then, or if it never is, whatever was written
// is removed.
class PartialFile {
 public:
  explicit PartialFile(const std::string& final_path);
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  const std::string& path() const { return path_; }
  // Nobody may have the file open. ALREADY_EXISTS: never over a file that somebody made meanwhile.
  absl::Status Finish() const;

 private:
  void Remove();

  const std::string final_path_;
  const std::string path_;
};

}  // namespace semmap::storage::sqlite
