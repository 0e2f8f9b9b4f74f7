#pragma once

#include <string>
#include <vector>

#include "nlohmann/json.hpp"
#include "tests/bench/slam_bench_run.h"

namespace semmap::bench {

// Figures of one run, or medians over several with each run under "runs". `ate_rmse_m` is null without ground
// truth.
nlohmann::json ReportJson(const std::vector<RunResult>& runs);

// The same for people: totals, and median and 95th percentile of each stage.
std::string ReportTable(const std::vector<RunResult>& runs);

}  // namespace semmap::bench
