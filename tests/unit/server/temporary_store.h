#pragma once

#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>

#include "storage/map_store.h"

namespace semmap::server {

// A directory that goes with the object.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string path = (std::filesystem::temp_directory_path() / "semmap-test-XXXXXX").string();
    path_ = mkdtemp(path.data());
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::string& path() const { return path_; }
  std::string database_uri() const { return "sqlite://" + path_ + "/semmap.db"; }

 private:
  std::string path_;
};

inline std::unique_ptr<storage::MapStore> OpenStoreIn(const TemporaryDirectory& directory) {
  storage::StorageConfig config;
  config.uri = directory.database_uri();
  auto store = storage::OpenMapStore(config);
  return store.ok() ? std::move(store).value() : nullptr;
}

}  // namespace semmap::server
