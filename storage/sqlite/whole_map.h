#pragma once

#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// Hands the whole map to the reader; inside the caller's read transaction.
absl::Status ReadWholeMap(Connection& connection, MapId map, MapReader* reader);

}  // namespace semmap::storage::sqlite
