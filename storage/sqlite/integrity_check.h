#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// All of MapStore::CheckIntegrity; the caller holds a read transaction. Memory grows with the number of
// points, by some tens of bytes each.
absl::StatusOr<std::vector<IntegrityFinding>> CheckMapIntegrity(Connection& connection, MapId map,
                                                                size_t max_findings);

}  // namespace semmap::storage::sqlite
