#include "slam/common/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap {
namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(const std::string& path) : value_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~FileDescriptor() {
    if (value_ >= 0) close(value_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;

  int value() const { return value_; }

 private:
  int value_;
};

absl::StatusOr<size_t> SizeOfRegularFile(int descriptor, const std::string& path) {
  struct stat information {};
  if (fstat(descriptor, &information) != 0) return absl::ErrnoToStatus(errno, path);
  if (!S_ISREG(information.st_mode)) return absl::InvalidArgumentError(absl::StrCat(path, ": is not a file"));
  if (information.st_size == 0) return absl::InvalidArgumentError(absl::StrCat(path, ": is empty"));
  return static_cast<size_t>(information.st_size);
}

}  // namespace

absl::StatusOr<MappedFile> MappedFile::Open(const std::string& path) {
  const FileDescriptor file(path);
  if (file.value() < 0) return absl::ErrnoToStatus(errno, path);
  SEMMAP_ASSIGN_OR_RETURN(const size_t size, SizeOfRegularFile(file.value(), path));
  void* address = mmap(nullptr, size, PROT_READ, MAP_SHARED, file.value(), 0);
  if (address == MAP_FAILED) return absl::ErrnoToStatus(errno, path);
  return MappedFile(std::span(static_cast<const std::byte*>(address), size));
}

MappedFile::MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  return *this;
}

MappedFile::~MappedFile() {
  // munmap does not write through the pointer.
  if (!bytes_.empty()) munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace semmap
