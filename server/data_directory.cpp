#include "server/data_directory.h"

#include <filesystem>
#include <string_view>

#include "absl/strings/str_cat.h"

namespace semmap::server {
namespace {

constexpr std::string_view kSqliteScheme = "sqlite:";

}  // namespace

absl::Status UseDataDirectory(const std::string& directory, storage::StorageConfig* config) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  const std::filesystem::path absolute = std::filesystem::absolute(directory, error);
  if (error || !std::filesystem::is_directory(absolute, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat(directory, " is not a directory and cannot be made one"));
  }
  const std::string path = config->uri.substr(std::min(config->uri.size(), kSqliteScheme.size()));
  const bool relative = config->uri.starts_with(kSqliteScheme) && !path.starts_with("/");
  if (relative) config->uri = absl::StrCat(std::string(kSqliteScheme), "//", (absolute / path).string());
  return absl::OkStatus();
}

}  // namespace semmap::server
