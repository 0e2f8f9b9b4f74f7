#include "storage/sqlite/partial_file.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"

namespace semmap::storage::sqlite {

PartialFile::PartialFile(const std::string& final_path)
    : final_path_(final_path), path_(absl::StrCat(final_path, ".part")) {
  Remove();
}

PartialFile::~PartialFile() { Remove(); }

absl::Status PartialFile::Finish() const {
  std::error_code error;
  std::filesystem::create_hard_link(path_, final_path_, error);
  if (error == std::errc::file_exists) {
    return absl::AlreadyExistsError(absl::StrCat(final_path_, " exists"));
  }
  if (error) return absl::InternalError(absl::StrCat("cannot make ", final_path_, ": ", error.message()));
  return absl::OkStatus();
}

void PartialFile::Remove() {
  std::error_code ignored;
  for (const char* suffix : {"", "-journal", "-wal", "-shm"}) {
    std::filesystem::remove(path_ + suffix, ignored);
  }
}

}  // namespace semmap::storage::sqlite
