#include "server/data_directory.h"

#include <filesystem>
#include <string_view>

#include "absl/strings/str_cat.h"

namespace semmap::server {
namespace {

constexpr std::string_view kSqliteScheme = "sqlite:";

}  // namespace

absl::Status UseDataDirectory(const std::string& directory, Config* config) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  const std::filesystem::path absolute = std::filesystem::absolute(directory, error);
  if (error || !std::filesystem::is_directory(absolute, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat(directory, " is not a directory and cannot be made one"));
  }
  const std::string path =
      config->storage.uri.substr(std::min(config->storage.uri.size(), kSqliteScheme.size()));
  const bool relative = config->storage.uri.starts_with(kSqliteScheme) && !path.starts_with("/");
  if (relative)
    config->storage.uri = absl::StrCat(std::string(kSqliteScheme), "//", (absolute / path).string());
  // An absolute one stays as it is.
  config->server.artifact_directory = absolute / config->server.artifact_directory;
  return absl::OkStatus();
}

}  // namespace semmap::server
