#pragma once

#include <string>

#include "absl/status/status.h"

struct sqlite3;

namespace semmap::storage::sqlite {

// The status that stands for SQLite's extended result code `code` at the outer interface, with SQLite's own
// message; `doing` says what was tried. OK for SQLITE_OK, SQLITE_ROW and SQLITE_DONE. `database` may be null.
absl::Status SqliteStatus(sqlite3* database, int code, const std::string& doing);

// Whether `status` came from a violated constraint: the data contradicts itself, not the database.
bool IsConstraintViolation(const absl::Status& status);

}  // namespace semmap::storage::sqlite
