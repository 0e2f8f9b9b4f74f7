#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "storage/map_store.h"

namespace semmap::storage::sqlite {

// MapStore in one SQLite file: one connection that writes and a pool of connections that read beside it
// (write-ahead log). See OpenMapStore for the errors. Several processes may open the same file on a local
// file system.
absl::StatusOr<std::unique_ptr<MapStore>> OpenSqliteMapStore(const StorageConfig& config);

}  // namespace semmap::storage::sqlite
