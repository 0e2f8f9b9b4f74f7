#pragma once

#include <optional>
#include <string>

#include "client/cli/eval_input.h"
#include "nlohmann/json.hpp"
#include "slam/evaluation/ate.h"
#include "slam/evaluation/mape.h"
#include "slam/evaluation/rpe.h"

namespace semmap::client {

// Everything that `eval rpe` found.
struct RpeResult {
  double scale = 1.0;
  IntervalRpeOptions interval_options;
  IntervalRpeResult interval;
  std::optional<SegmentRpeResult> segments;  // none: the path is too short
};

// For programs: rmse, mean, median, max, min, std (metres), pairs, scale, and what was compared.
nlohmann::json AteJson(const EvalOptions& options, const EvalInput& input, const AteResult& ate);
nlohmann::json RpeJson(const EvalOptions& options, const EvalInput& input, const RpeResult& rpe);
nlohmann::json MapeJson(const EvalOptions& options, const EvalInput& input, const MapeResult& mape);

// For people.
std::string AteTable(const EvalOptions& options, const EvalInput& input, const AteResult& ate);
std::string RpeTable(const EvalInput& input, const RpeResult& rpe);
std::string MapeTable(const EvalInput& input, const MapeResult& mape);

}  // namespace semmap::client
