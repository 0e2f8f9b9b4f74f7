#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "client/cli/area_options.h"
#include "semmap/v1/query.pb.h"

namespace semmap::client {

// Which points of a map are meant: the options that all commands share that deal with points.
struct PointFilterOptions {
  AreaOptions area;
  std::vector<std::string> classes;  // names or numbers
  int min_observations = 0;
  double min_confidence = 0;
  std::optional<int64_t> seen_from_ns;
  std::optional<int64_t> seen_until_ns;
  bool active_only = false;
};

void AddPointFilterOptions(CLI::App& command, PointFilterOptions* options);
// A UsageError for a class that there is not.
absl::StatusOr<v1::MapPointFilter> FilterOf(const PointFilterOptions& options);

}  // namespace semmap::client
