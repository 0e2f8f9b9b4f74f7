#pragma once

#include <array>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/common/time.h"

namespace semmap {

// Reads a text table (TUM, KITTI, EuRoC, ...) line by line: skips empty lines and '#' comments, splits the
// others at blanks or commas, and knows the line number for complaints. Lines and line counts are bounded, so
// that a wrong file (a video, /dev/zero) ends in an error. Not thread-safe.
class LineReader {
 public:
  static constexpr size_t kMaxLineBytes = 4096;
  static constexpr size_t kMaxLines = 20'000'000;

  // NOT_FOUND when the file cannot be opened.
  static absl::StatusOr<LineReader> Open(const std::string& path);

  // Moves to the next line with content; false at the end and after an error, which Finish() tells apart.
  bool Next();
  const std::vector<absl::string_view>& fields() const { return fields_; }
  // INVALID_ARGUMENT "file:line: reason" for the line at hand.
  absl::Status Error(absl::string_view reason) const;
  // The error that stopped Next(), if any.
  absl::Status Finish() const { return status_; }

  // The field as a finite number, or as seconds; nothing when it is none or the line has no such field.
  std::optional<double> Number(size_t field) const;
  std::optional<TimestampNs> Seconds(size_t field) const;

 private:
  LineReader(std::string path, std::ifstream stream);

  std::string path_;
  std::ifstream stream_;
  // On the heap, so that the fields stay valid when the reader is moved.
  std::unique_ptr<std::array<char, kMaxLineBytes>> line_;
  size_t line_number_ = 0;
  std::vector<absl::string_view> fields_;
  absl::Status status_;
};

// Seconds in decimal, exact to the nanosecond (a double is not, for times since 1970); nothing for what is no
// number or lies beyond the year 2200.
std::optional<TimestampNs> ParseSeconds(absl::string_view text);
// "12.345678900": nine digits after the point, read back exactly by ParseSeconds.
std::string FormatSeconds(TimestampNs timestamp);

}  // namespace semmap
