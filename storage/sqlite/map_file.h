#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

// A map as a file of its own: a database of this schema that holds one map and nothing else. It can be opened
// as a store.
namespace semmap::storage::sqlite {

// Writes `map`, which the database of `source` holds, as it is at one instant. MapStore::ExportMap's errors.
absl::Status WriteMapFile(const ConnectionOptions& source, const MapInfo& map, const std::string& path,
                          const ProgressVisitor& progress);

// Whether a file, which may come from anywhere, is a sound map, and which one: its schema is that of this or
// an earlier version to the letter (so that nothing in it does more than store), its structure is whole,
// references and numbers are right, and all values are such as a vehicle's session could have stored. An
// earlier version is upgraded in place. INVALID_ARGUMENT says what is wrong with it.
absl::StatusOr<MapId> CheckMapFile(const ConnectionOptions& file);

// Makes the database `path` readable by the connection's statements as "source".
absl::Status AttachSource(Connection& connection, const std::string& path);

}  // namespace semmap::storage::sqlite
