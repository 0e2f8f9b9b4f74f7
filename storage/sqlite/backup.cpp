#include "storage/sqlite/backup.h"

#include <filesystem>
#include <system_error>

#include <sqlite3.h>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/partial_file.h"
#include "storage/sqlite/sqlite_status.h"

namespace semmap::storage::sqlite {
namespace {

// Four megabytes between looks at the caller's wish to stop.
constexpr int kPagesPerStep = 1024;

absl::Status CopyPages(Connection& source, Connection& target, const ProgressVisitor& progress) {
  sqlite3_backup* backup = sqlite3_backup_init(target.handle(), "main", source.handle(), "main");
  int code = backup == nullptr ? sqlite3_extended_errcode(target.handle()) : SQLITE_OK;
  bool cancelled = false;
  while (code == SQLITE_OK && !cancelled) {
    code = sqlite3_backup_step(backup, kPagesPerStep);
    const double pages = sqlite3_backup_pagecount(backup);
    const double done = pages > 0 ? 1 - sqlite3_backup_remaining(backup) / pages : 1;
    cancelled = progress && !progress(done);
  }
  sqlite3_backup_finish(backup);
  if (cancelled) return absl::CancelledError("the backup was cancelled");
  return code == SQLITE_DONE ? absl::OkStatus()
                             : SqliteStatus(target.handle(), code, absl::StrCat("writing ", target.path()));
}

}  // namespace

absl::Status BackupDatabase(Connection& source, const std::string& path, const ProgressVisitor& progress) {
  std::error_code error;
  if (std::filesystem::exists(path, error)) return absl::AlreadyExistsError(absl::StrCat(path, " exists"));
  const PartialFile partial(path);
  {
    ConnectionOptions options;
    options.path = partial.path();
    options.full_synchronous = true;
    SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Connection> target, Connection::Open(options));
    SEMMAP_RETURN_IF_ERROR(CopyPages(source, *target, progress));
  }
  return partial.Finish();
}

}  // namespace semmap::storage::sqlite
