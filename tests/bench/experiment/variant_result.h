#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "absl/status/statusor.h"
#include "nlohmann/json.hpp"
#include "tests/bench/experiment/map_census.h"

namespace semmap::bench {

// What one variant made of one drive.
struct VariantResult {
  std::string route;
  uint64_t traffic_seed = 0;
  // See RunOptions.
  int run = 1;
  std::string variant;

  int frames = 0;
  int tracked = 0;  // frames with a pose in the final map
  double duration_s = 0;
  double length_m = 0;  // driven, by the truth
  // Nothing when too few poses are left to align.
  std::optional<double> mape_percent;
  std::optional<double> ate_m;
  int keyframes = 0;
  int points = 0;
  int loops = 0;
  int recoveries = 0;
  double track_ms = 0;  // median of a frame
  MapCensus census;

  // Of the tracked frames: frame number, error in the ground plane, and where the camera was in the town's
  // frame by the aligned estimate.
  std::vector<int> frame;
  std::vector<double> error_m;
  std::vector<Eigen::Vector2d> estimate;
};

nlohmann::json ToJson(const VariantResult& result);
// DATA_LOSS when something is missing or of another kind.
absl::StatusOr<VariantResult> ResultFromJson(const nlohmann::json& json);

}  // namespace semmap::bench
