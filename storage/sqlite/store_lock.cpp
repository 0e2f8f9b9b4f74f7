#include "storage/sqlite/store_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

namespace semmap::storage::sqlite {

StoreLock::StoreLock(const std::string& database) {
  if (database == ":memory:") return;
  file_ = open((database + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640);
  if (file_ >= 0) is_alone_ = flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

StoreLock::~StoreLock() {
  if (file_ >= 0) close(file_);
}

void StoreLock::Share() const {
  if (file_ < 0) return;
  while (flock(file_, LOCK_SH) != 0 && errno == EINTR) {
  }
}

}  // namespace semmap::storage::sqlite
