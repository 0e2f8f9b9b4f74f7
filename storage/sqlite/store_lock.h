#pragma once

#include <string>

namespace semmap::storage::sqlite {

// Tells who opens a database whether another process, or store, has it open as well: what looks like the
// remains of a crash may then be its work in progress. A lock on a file beside the database, which the system
// lets go when its holder dies. Where the file cannot be made, everybody is alone.
class StoreLock {
 public:
  // A database without a file (":memory:") has no others.
  explicit StoreLock(const std::string& database);
  ~StoreLock();
  StoreLock(const StoreLock&) = delete;
  StoreLock& operator=(const StoreLock&) = delete;

  // Nobody else has the store open. Others who open it wait until Share.
  bool is_alone() const { return is_alone_; }
  // Once the remains of crashes are gone. Waits for another one that has not come so far.
  void Share() const;

 private:
  int file_ = -1;
  bool is_alone_ = true;
};

}  // namespace semmap::storage::sqlite
