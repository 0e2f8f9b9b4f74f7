#pragma once

#include <span>

#include "absl/status/status.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// A numbered step of the schema, storage/migrations/NNNN_name.sql.
struct Migration {
  int version;  // from 1, without gaps
  const char* name;
  const char* sql;
};

// Those that this program was built with.
std::span<const Migration> EmbeddedMigrations();

// "smap": marks a database file as one of ours (PRAGMA application_id).
constexpr int64_t kApplicationId = 0x736D6170;

// Brings the file behind `connection` to the last of `migrations` (PRAGMA user_version), all missing ones in
// one transaction under an exclusive lock, and switches it to a write-ahead log; a file without any content
// becomes a new database. Safe to call from several processes at once. FAILED_PRECONDITION, without touching
// the file, when it is somebody else's database or of a version that is not in `migrations` yet.
absl::Status MigrateDatabase(Connection& connection, std::span<const Migration> migrations);

}  // namespace semmap::storage::sqlite
