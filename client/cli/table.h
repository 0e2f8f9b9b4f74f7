#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace semmap::client {

// Rows under a heading, columns as wide as they need; columns whose every cell is a number are flushed right.
class Table {
 public:
  explicit Table(std::vector<std::string> heading) : heading_(std::move(heading)) {}

  void AddRow(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  bool empty() const { return rows_.empty(); }
  std::string Format() const;

 private:
  std::vector<std::string> heading_;
  std::vector<std::vector<std::string>> rows_;
};

// "2024-05-01 12:00:00" (UTC) of seconds since 1970; "-" for 0.
std::string FormatUtc(int64_t unix_seconds);
// "1.5 MiB".
std::string FormatBytes(int64_t bytes);

}  // namespace semmap::client
