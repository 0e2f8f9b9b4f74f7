#include "server/output_file.h"

#include "server/error_reasons.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

// Space is taken in steps, so that not every point asks for it.
constexpr int64_t kStep = 1 << 20;

absl::Status NotWritten() {
  return Error(v1::ERROR_REASON_STORE_UNAVAILABLE, "the server's disk does not take the file");
}

}  // namespace

OutputFile::OutputFile(PendingFile* file)
    : file_(file), stream_(file->path(), std::ios::binary | std::ios::trunc) {}

absl::Status OutputFile::Append(std::string_view bytes) {
  size_ += static_cast<int64_t>(bytes.size());
  if (size_ > reserved_) {
    const int64_t wanted = (size_ + kStep - 1) / kStep * kStep;
    // The last step may be too long where the file itself is not.
    const bool whole_step = file_->GrowTo(wanted).ok();
    if (!whole_step) SEMMAP_RETURN_IF_ERROR(file_->GrowTo(size_));
    reserved_ = whole_step ? wanted : size_;
  }
  if (!stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return NotWritten();
  return absl::OkStatus();
}

absl::Status OutputFile::ReplaceBeginning(std::string_view bytes) {
  stream_.seekp(0);
  stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream_.seekp(size_);
  return stream_ ? absl::OkStatus() : NotWritten();
}

absl::Status OutputFile::Close() {
  stream_.close();
  return stream_ ? absl::OkStatus() : NotWritten();
}

}  // namespace semmap::server
