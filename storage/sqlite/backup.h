#pragma once

#include <string>

#include "absl/status/status.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// Copies the database, as the read transaction that is open on `source` sees it, to a new file at `path`.
absl::Status BackupDatabase(Connection& source, const std::string& path, const ProgressVisitor& progress);

}  // namespace semmap::storage::sqlite
