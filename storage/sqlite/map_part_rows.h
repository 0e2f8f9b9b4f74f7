#pragma once

#include "absl/functional/function_ref.h"
#include "slam/map/map_parts.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// MapStore::ReadParts inside the caller's read transaction.
absl::Status ReadMapParts(Connection& connection, MapId map,
                          absl::FunctionRef<absl::Status(MapPartReader&)> read);

}  // namespace semmap::storage::sqlite
