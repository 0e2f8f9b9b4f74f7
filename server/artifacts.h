#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "slam/common/mutex.h"
#include "slam/common/time.h"

namespace semmap::server {

// A file that an operation made for a client to fetch.
struct Artifact {
  std::string id;  // of "artifacts/{id}"; nobody can guess it
  std::string path;
  int64_t size_bytes = 0;
  std::string sha256;          // 32 bytes
  TimestampNs expires_at = 0;  // Unix epoch
};

class PendingFile;

// The files of imports and exports: they lie in a directory of the server's own, together take a bounded
// number of bytes, and are deleted when their time is over. They do not outlive the server. Thread-safe.
class Artifacts {
 public:
  // The directory is made, and cleared of what an earlier run left, when the first file is begun.
  Artifacts(std::string directory, int64_t max_bytes, absl::Duration lifetime,
            std::function<TimestampNs()> wall_clock);
  ~Artifacts();
  Artifacts(const Artifacts&) = delete;
  Artifacts& operator=(const Artifacts&) = delete;

  // STORE_UNAVAILABLE when the directory cannot be made.
  absl::StatusOr<std::unique_ptr<PendingFile>> Begin();
  // Makes a file that is complete an artifact. FILES_TOO_LARGE, STORE_UNAVAILABLE; the file is gone then.
  absl::StatusOr<Artifact> Publish(std::unique_ptr<PendingFile> file);

  // ARTIFACT_NOT_FOUND, also when its time is over.
  absl::StatusOr<Artifact> Find(const std::string& id);
  // One that is not there is no error.
  void Remove(const std::string& id);
  void RemoveExpired();

  absl::Duration lifetime() const { return lifetime_; }

 private:
  friend class PendingFile;

  absl::Status MakeDirectory() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Take(int64_t bytes);

  const std::string directory_;
  const absl::Duration lifetime_;
  const std::function<TimestampNs()> wall_clock_;

  Mutex mutex_;  // guards all below
  std::map<std::string, Artifact> artifacts_ ABSL_GUARDED_BY(mutex_);
  int64_t free_bytes_ ABSL_GUARDED_BY(mutex_);
  bool directory_made_ ABSL_GUARDED_BY(mutex_) = false;
};

// A file that is being written; deleted with the object unless it was published. Does not outlive its
// Artifacts.
class PendingFile {
 public:
  PendingFile(Artifacts* owner, std::string path);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  // Nothing is there yet: whoever writes makes the file.
  const std::string& path() const { return path_; }
  // To be called before the file has so many bytes. FILES_TOO_LARGE when all files together may not.
  absl::Status GrowTo(int64_t bytes);

 private:
  friend class Artifacts;

  Artifacts* const owner_;
  const std::string path_;
  int64_t taken_ = 0;
  bool published_ = false;
};

}  // namespace semmap::server
