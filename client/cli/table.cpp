#include "client/cli/table.h"

#include <algorithm>
#include <array>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"

namespace semmap::client {
namespace {

struct Column {
  size_t width = 0;
  bool numeric = true;
};

std::string Pad(const std::string& cell, const Column& column) {
  const std::string blanks(column.width - cell.size(), ' ');
  return column.numeric ? blanks + cell : cell + blanks;
}

std::string FormatRow(const std::vector<std::string>& cells, const std::vector<Column>& columns) {
  std::string line;
  for (size_t i = 0; i < columns.size(); ++i) {
    absl::StrAppend(&line, i == 0 ? "" : "  ", Pad(i < cells.size() ? cells[i] : "", columns[i]));
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

std::string Table::Format() const {
  std::vector<Column> columns(heading_.size());
  for (size_t i = 0; i < columns.size(); ++i) {
    columns[i].width = heading_[i].size();
    for (const std::vector<std::string>& row : rows_) {
      if (i >= row.size()) continue;
      double number = 0;
      columns[i].width = std::max(columns[i].width, row[i].size());
      columns[i].numeric = columns[i].numeric && absl::SimpleAtod(row[i], &number);
    }
  }
  std::string text = FormatRow(heading_, columns);
  for (const std::vector<std::string>& row : rows_) text += FormatRow(row, columns);
  return text;
}

std::string FormatUtc(int64_t unix_seconds) {
  if (unix_seconds == 0) return "-";
  return absl::FormatTime("%Y-%m-%d %H:%M:%S", absl::FromUnixSeconds(unix_seconds), absl::UTCTimeZone());
}

std::string FormatBytes(int64_t bytes) {
  constexpr std::array<const char*, 5> kUnits = {"B", "KiB", "MiB", "GiB", "TiB"};
  double value = static_cast<double>(bytes);
  size_t unit = 0;
  for (; value >= 1024 && unit + 1 < kUnits.size(); ++unit) value /= 1024;
  return unit == 0 ? absl::StrFormat("%d B", bytes) : absl::StrFormat("%.1f %s", value, kUnits[unit]);
}

}  // namespace semmap::client
