#include "tests/bench/map_scale/map_scale_report.h"

#include <algorithm>

#include "absl/strings/str_format.h"
#include "slam/evaluation/statistics.h"

namespace semmap::bench {
namespace {

double Most(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

double Share(uint64_t part, size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

nlohmann::json MapScaleJson(const MapScaleResult& r) {
  const auto per = [&](double count) { return count > 0 ? static_cast<double>(r.file_bytes) / count : 0; };
  return {{"keyframes", r.keyframes},
          {"points", r.points},
          {"kilometres", r.kilometres},
          {"file_bytes", r.file_bytes},
          {"file_bytes_per_keyframe", per(static_cast<double>(r.keyframes))},
          {"file_bytes_per_kilometre", per(r.kilometres)},
          {"disk_open_ms", r.from_disk.open_ms},
          {"disk_first_answer_ms", r.from_disk.first_answer_ms},
          {"open_ms", r.from_page_cache.open_ms},
          {"first_answer_ms", r.from_page_cache.first_answer_ms},
          {"queries", r.relocalize_ms.size()},
          {"found_share", Share(r.found, r.relocalize_ms.size())},
          {"right_share", Share(r.right, r.relocalize_ms.size())},
          {"relocalize_median_ms", Percentile(r.relocalize_ms, 0.5)},
          {"relocalize_p95_ms", Percentile(r.relocalize_ms, 0.95)},
          {"relocalize_max_ms", Most(r.relocalize_ms)},
          {"extract_median_ms", Percentile(r.extract_ms, 0.5)},
          {"localize_frames", r.localize_ms.size()},
          {"localized_share", Share(r.localized, r.localize_ms.size())},
          {"localize_median_ms", Percentile(r.localize_ms, 0.5)},
          {"localize_p95_ms", Percentile(r.localize_ms, 0.95)},
          {"localize_max_ms", Most(r.localize_ms)},
          {"resident_mb", r.resident_mb},
          {"peak_mb", r.peak_mb},
          {"before_mb", r.before_mb},
          {"map_mb", r.map_mb},
          {"core_mb", r.core_mb},
          {"box_points_median", Percentile(r.box_points, 0.5)},
          {"box_median_ms", Percentile(r.box_ms, 0.5)},
          {"box_p95_ms", Percentile(r.box_ms, 0.95)}};
}

std::string MapScaleTable(const MapScaleResult& result) {
  const nlohmann::json json = MapScaleJson(result);
  std::string table;
  const auto line = [&](const char* what, const std::string& value, const char* aim) {
    table += absl::StrFormat("%-52s %16s   %s\n", what, value, aim);
  };
  const auto number = [&](const char* key, const char* unit, double scale = 1) {
    return absl::StrFormat("%.1f %s", json[key].get<double>() * scale, unit);
  };
  line("", "measured", "aim");
  line("keyframes", absl::StrFormat("%d", result.keyframes), "10000");
  line("points", absl::StrFormat("%d", result.points), "1000000");
  line("length of the drives", number("kilometres", "km"), "");
  line("opening to the first answer, with extraction", number("first_answer_ms", "ms"), "1000 ms");
  line("  of that, opening", number("open_ms", "ms"), "");
  line("the same, file in no cache of the system", number("disk_first_answer_ms", "ms"), "1000 ms");
  line("  of that, opening", number("disk_open_ms", "ms"), "");
  line("relocalize, median, without extraction", number("relocalize_median_ms", "ms"), "100 ms");
  line("relocalize, 95th percentile", number("relocalize_p95_ms", "ms"), "100 ms");
  line("relocalize, longest", number("relocalize_max_ms", "ms"), "");
  line("extraction, median", number("extract_median_ms", "ms"), "");
  line("found", number("found_share", "%", 100), "");
  line("within 0.5 m and 5 degrees", number("right_share", "%", 100), "");
  line("a vehicle in the map: frame, median", number("localize_median_ms", "ms"), "");
  line("a vehicle in the map: frame, 95th percentile", number("localize_p95_ms", "ms"), "");
  line("a vehicle in the map: frame, longest", number("localize_max_ms", "ms"), "");
  line("a vehicle in the map: tracked", number("localized_share", "%", 100), "");
  line("memory of the map, accounted", number("map_mb", "MB"), "512 MB");
  line("  of that, outline and place index", number("core_mb", "MB"), "");
  line("resident, whole process", number("resident_mb", "MB"), "512 MB");
  line("resident at most", number("peak_mb", "MB"), "");
  line("resident before the map", number("before_mb", "MB"), "");
  line("box query, points, median", number("box_points_median", ""), "10000");
  line("box query, median", number("box_median_ms", "ms"), "20 ms");
  line("box query, 95th percentile", number("box_p95_ms", "ms"), "");
  line("file, per keyframe", number("file_bytes_per_keyframe", "kB", 1e-3), "60 kB");
  line("file, per kilometre", number("file_bytes_per_kilometre", "MB", 1e-6), "");
  return table;
}

}  // namespace semmap::bench
