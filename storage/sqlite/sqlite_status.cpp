#include "storage/sqlite/sqlite_status.h"

#include <sqlite3.h>

#include <cerrno>

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kConstraintPayload[] = "semmap.storage.sqlite.constraint";

// Limits on space that SQLite itself reports as a mere failure to write. It keeps the system's error of a
// failed statement, but not that of a failed COMMIT: of that errno still tells.
bool IsOutOfSpace(sqlite3* database, int last_errno) {
  const int kept = database == nullptr ? 0 : sqlite3_system_errno(database);
  const auto is_space = [](int error) { return error == ENOSPC || error == EFBIG || error == EDQUOT; };
  return is_space(kept) || (kept == 0 && is_space(last_errno));
}

absl::StatusCode IoErrorCode(sqlite3* database, int code, int last_errno) {
  // Growing the shared index of the log fails with this when the disk is full.
  if (code == SQLITE_IOERR_SHMSIZE || IsOutOfSpace(database, last_errno))
    return absl::StatusCode::kResourceExhausted;
  if (code == SQLITE_IOERR_NOMEM) return absl::StatusCode::kResourceExhausted;
  return absl::StatusCode::kInternal;
}

absl::StatusCode CodeOf(sqlite3* database, int code, int last_errno) {
  switch (code & 0xFF) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_PROTOCOL:
      return absl::StatusCode::kUnavailable;
    case SQLITE_FULL:
    case SQLITE_NOMEM:
      return absl::StatusCode::kResourceExhausted;
    case SQLITE_IOERR:
      return IoErrorCode(database, code, last_errno);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::StatusCode::kDataLoss;
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
    case SQLITE_AUTH:
      return absl::StatusCode::kPermissionDenied;
    case SQLITE_CONSTRAINT:
    case SQLITE_MISMATCH:
    case SQLITE_TOOBIG:
    case SQLITE_RANGE:
      return absl::StatusCode::kInvalidArgument;
    case SQLITE_INTERRUPT:
      return absl::StatusCode::kCancelled;
    default:
      return absl::StatusCode::kInternal;
  }
}

}  // namespace

absl::Status SqliteStatus(sqlite3* database, int code, const std::string& doing) {
  if (code == SQLITE_OK || code == SQLITE_ROW || code == SQLITE_DONE) return absl::OkStatus();
  const int last_errno = errno;
  const char* detail = database != nullptr ? sqlite3_errmsg(database) : sqlite3_errstr(code);
  absl::Status status(CodeOf(database, code, last_errno),
                      absl::StrCat(doing, ": ", detail, " (SQLite code ", code, ")"));
  if ((code & 0xFF) == SQLITE_CONSTRAINT) status.SetPayload(kConstraintPayload, absl::Cord());
  return status;
}

bool IsConstraintViolation(const absl::Status& status) {
  return status.GetPayload(kConstraintPayload).has_value();
}

}  // namespace semmap::storage::sqlite
