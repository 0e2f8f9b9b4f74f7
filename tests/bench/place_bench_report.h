#pragma once

#include <string>
#include <vector>

#include "nlohmann/json.hpp"
#include "tests/bench/place_bench_recall.h"
#include "tests/bench/place_bench_scaling.h"

namespace semmap::bench {

struct PlaceReport {
  std::string vocabulary;
  size_t vocabulary_bytes = 0;
  size_t words = 0;
  double load_ms = 0;
  std::vector<RecallResult> recall;
  ScalingResult scaling;
};

nlohmann::json ReportJson(const PlaceReport& report);
// The same as Markdown tables.
std::string ReportTables(const PlaceReport& report);

}  // namespace semmap::bench
