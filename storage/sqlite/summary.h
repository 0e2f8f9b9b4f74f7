#pragma once

#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// All of MapStore::Summarize; the caller holds a read transaction.
absl::StatusOr<MapSummary> SummarizeMap(Connection& connection, MapId map);
// The database file and its log.
absl::StatusOr<uint64_t> DatabaseBytes(Connection& connection);

}  // namespace semmap::storage::sqlite
