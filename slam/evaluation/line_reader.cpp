#include "slam/evaluation/line_reader.h"

#include <array>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace semmap {
namespace {

constexpr double kMaxSeconds = 7.3e9;
constexpr TimestampNs kNanosecondsPerSecond = 1'000'000'000;
constexpr size_t kFractionDigits = 9;

bool IsDigits(absl::string_view text) {
  for (const char c : text) {
    if (!absl::ascii_isdigit(static_cast<unsigned char>(c))) return false;
  }
  return true;
}

// "123456" behind the point as nanoseconds; digits beyond the ninth are cut off.
TimestampNs FractionToNanoseconds(absl::string_view digits) {
  TimestampNs value = 0;
  for (size_t i = 0; i < kFractionDigits; ++i) value = value * 10 + (i < digits.size() ? digits[i] - '0' : 0);
  return value;
}

std::optional<TimestampNs> ParseFloatSeconds(absl::string_view text) {
  double seconds = 0;
  if (!absl::SimpleAtod(text, &seconds) || !(std::abs(seconds) <= kMaxSeconds)) return std::nullopt;
  return FromSeconds(seconds);
}

}  // namespace

LineReader::LineReader(std::string path, std::ifstream stream)
    : path_(std::move(path)),
      stream_(std::move(stream)),
      line_(std::make_unique<std::array<char, kMaxLineBytes>>()) {}

absl::StatusOr<LineReader> LineReader::Open(const std::string& path) {
  std::ifstream stream(path);
  if (!stream) return absl::NotFoundError(absl::StrCat(path, ": cannot be opened"));
  return LineReader(path, std::move(stream));
}

bool LineReader::Next() {
  while (status_.ok()) {
    stream_.getline(line_->data(), line_->size());
    if (stream_.bad() || (stream_.eof() && stream_.gcount() == 0)) return false;
    ++line_number_;
    if (stream_.fail() && !stream_.eof()) {
      status_ = stream_.gcount() == 0
                    ? Error("cannot be read")
                    : Error(absl::StrCat("line is longer than ", kMaxLineBytes - 1, " bytes"));
    } else if (line_number_ > kMaxLines) {
      status_ = Error(absl::StrCat("file has more than ", kMaxLines, " lines"));
    } else {
      fields_ =
          absl::StrSplit(absl::string_view(line_->data()), absl::ByAnyChar(" \t\r,"), absl::SkipEmpty());
      if (!fields_.empty() && fields_.front().front() != '#') return true;
    }
  }
  return false;
}

absl::Status LineReader::Error(absl::string_view reason) const {
  return absl::InvalidArgumentError(absl::StrCat(path_, ":", line_number_, ": ", reason));
}

std::optional<double> LineReader::Number(size_t field) const {
  double value = 0;
  if (field >= fields_.size() || !absl::SimpleAtod(fields_[field], &value) || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::optional<TimestampNs> LineReader::Seconds(size_t field) const {
  if (field >= fields_.size()) return std::nullopt;
  return ParseSeconds(fields_[field]);
}

std::optional<TimestampNs> ParseSeconds(absl::string_view text) {
  const bool negative = !text.empty() && text.front() == '-';
  const absl::string_view digits = text.substr(negative ? 1 : 0);
  const size_t point = digits.find('.');
  const absl::string_view whole = digits.substr(0, point);
  const absl::string_view fraction = point == absl::string_view::npos ? "" : digits.substr(point + 1);
  if (whole.empty() || !IsDigits(whole) || !IsDigits(fraction)) return ParseFloatSeconds(text);
  int64_t seconds = 0;
  if (!absl::SimpleAtoi(whole, &seconds) || static_cast<double>(seconds) > kMaxSeconds) return std::nullopt;
  const TimestampNs value = seconds * kNanosecondsPerSecond + FractionToNanoseconds(fraction);
  return negative ? -value : value;
}

std::string FormatSeconds(TimestampNs timestamp) {
  const TimestampNs magnitude = std::abs(timestamp);
  return absl::StrFormat("%s%d.%09d", timestamp < 0 ? "-" : "", magnitude / kNanosecondsPerSecond,
                         magnitude % kNanosecondsPerSecond);
}

}  // namespace semmap
