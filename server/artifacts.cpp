#include "server/artifacts.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/error_reasons.h"
#include "server/random_id.h"
#include "slam/common/sha256.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

namespace fs = std::filesystem;

constexpr size_t kIdBytes = 16;
constexpr const char* kExtension = ".artifact";

// SQLite keeps journals beside its files.
void RemoveFile(const std::string& path) {
  std::error_code ignored;
  for (const char* suffix : {"", "-journal", "-wal", "-shm"}) fs::remove(path + suffix, ignored);
}

}  // namespace

Artifacts::Artifacts(std::string directory, int64_t max_bytes, absl::Duration lifetime,
                     std::function<TimestampNs()> wall_clock)
    : directory_(std::move(directory)),
      lifetime_(lifetime),
      wall_clock_(std::move(wall_clock)),
      free_bytes_(max_bytes) {}

Artifacts::~Artifacts() {
  MutexLock lock(&mutex_);
  for (const auto& [id, artifact] : artifacts_) RemoveFile(artifact.path);
}

absl::Status Artifacts::MakeDirectory() {
  if (directory_made_) return absl::OkStatus();
  std::error_code error;
  fs::create_directories(directory_, error);
  for (fs::directory_iterator file(directory_, error), end; !error && file != end; file.increment(error)) {
    if (file->path().filename().string().find(kExtension) == std::string::npos) continue;
    std::error_code ignored;
    fs::remove(file->path(), ignored);
  }
  if (error) {
    return Error(v1::ERROR_REASON_STORE_UNAVAILABLE,
                 absl::StrCat("the directory of artifacts cannot be used: ", error.message()));
  }
  directory_made_ = true;
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<PendingFile>> Artifacts::Begin() {
  RemoveExpired();
  MutexLock lock(&mutex_);
  SEMMAP_RETURN_IF_ERROR(MakeDirectory());
  return std::make_unique<PendingFile>(this, absl::StrCat(directory_, "/", RandomHex(kIdBytes), kExtension));
}

absl::StatusOr<Artifact> Artifacts::Publish(std::unique_ptr<PendingFile> file) {
  Artifact artifact;
  artifact.path = file->path();
  artifact.id = fs::path(file->path()).stem().string();
  std::error_code error;
  artifact.size_bytes = static_cast<int64_t>(fs::file_size(file->path(), error));
  if (error) return Error(v1::ERROR_REASON_STORE_UNAVAILABLE, "the file cannot be read");
  SEMMAP_RETURN_IF_ERROR(file->GrowTo(artifact.size_bytes));
  auto sha256 = Sha256OfFile(file->path());
  if (!sha256.ok()) return WithReason(sha256.status(), v1::ERROR_REASON_STORE_UNAVAILABLE);
  artifact.sha256 = *std::move(sha256);
  artifact.expires_at = wall_clock_() + absl::ToInt64Nanoseconds(lifetime_);
  MutexLock lock(&mutex_);
  artifacts_.emplace(artifact.id, artifact);
  free_bytes_ += file->taken_ - artifact.size_bytes;
  file->taken_ = 0;
  file->published_ = true;
  return artifact;
}

absl::StatusOr<Artifact> Artifacts::Find(const std::string& id) {
  RemoveExpired();
  MutexLock lock(&mutex_);
  const auto found = artifacts_.find(id);
  if (found != artifacts_.end()) return found->second;
  return Error(v1::ERROR_REASON_ARTIFACT_NOT_FOUND, absl::StrCat("there is no artifact ", id));
}

void Artifacts::Remove(const std::string& id) {
  MutexLock lock(&mutex_);
  const auto found = artifacts_.find(id);
  if (found == artifacts_.end()) return;
  RemoveFile(found->second.path);
  free_bytes_ += found->second.size_bytes;
  artifacts_.erase(found);
}

void Artifacts::RemoveExpired() {
  MutexLock lock(&mutex_);
  const TimestampNs now = wall_clock_();
  for (auto artifact = artifacts_.begin(); artifact != artifacts_.end();) {
    if (artifact->second.expires_at > now) {
      ++artifact;
      continue;
    }
    RemoveFile(artifact->second.path);
    free_bytes_ += artifact->second.size_bytes;
    artifact = artifacts_.erase(artifact);
  }
}

absl::Status Artifacts::Take(int64_t bytes) {
  MutexLock lock(&mutex_);
  if (bytes > free_bytes_) {
    return Error(v1::ERROR_REASON_FILES_TOO_LARGE,
                 "the files of imports and exports would take more space than they may");
  }
  free_bytes_ -= bytes;
  return absl::OkStatus();
}

PendingFile::PendingFile(Artifacts* owner, std::string path) : owner_(owner), path_(std::move(path)) {}

PendingFile::~PendingFile() {
  if (!published_) RemoveFile(path_);
  // Giving back never fails.
  owner_->Take(-taken_).IgnoreError();
}

absl::Status PendingFile::GrowTo(int64_t bytes) {
  if (bytes <= taken_) return absl::OkStatus();
  SEMMAP_RETURN_IF_ERROR(owner_->Take(bytes - taken_));
  taken_ = bytes;
  return absl::OkStatus();
}

}  // namespace semmap::server
