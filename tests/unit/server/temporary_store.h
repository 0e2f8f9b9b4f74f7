#pragma once

#include <memory>
#include <string>

#include "storage/map_store.h"
#include "tests/support/temporary_directory.h"

namespace semmap::server {

using semmap::TemporaryDirectory;

inline std::unique_ptr<storage::MapStore> OpenStoreIn(const TemporaryDirectory& directory) {
  storage::StorageConfig config;
  config.uri = directory.database_uri();
  auto store = storage::OpenMapStore(config);
  return store.ok() ? std::move(store).value() : nullptr;
}

}  // namespace semmap::server
