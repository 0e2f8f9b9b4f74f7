#pragma once

#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// MapStore::ReadOutline inside the caller's read transaction.
absl::Status ReadMapOutline(Connection& connection, MapId map, uint64_t vocabulary, MapOutlineReader* reader);

}  // namespace semmap::storage::sqlite
