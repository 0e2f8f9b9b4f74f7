#include "slam/common/data_files.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace semmap {

std::string DataFilePath(std::string_view relative) {
  if (const char* folder = std::getenv("SEMMAP_DATA_DIR"); folder != nullptr && *folder != '\0') {
    return std::filesystem::path(folder) / relative;
  }
  const std::filesystem::path installed = std::filesystem::path(SEMMAP_INSTALLED_DATA_DIR) / relative;
  std::error_code unreadable;
  if (std::filesystem::exists(installed, unreadable)) return installed;
  return std::filesystem::path(SEMMAP_SOURCE_DATA_DIR) / relative;
}

}  // namespace semmap
