#pragma once

#include <memory>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "slam/evaluation/association.h"
#include "slam/evaluation/ate.h"
#include "slam/evaluation/trajectory_io.h"

namespace semmap::client {

// The options that all metrics share.
struct EvalOptions {
  std::string reference;
  TrajectoryFormat reference_format = TrajectoryFormat::kTum;
  std::string reference_times;
  std::string estimate;
  TrajectoryFormat estimate_format = TrajectoryFormat::kTum;
  std::string estimate_times;
  Alignment alignment = Alignment::kSe3;
  double max_time_difference_s = kDefaultMaxTimeDifferenceS;
  std::string plot;
  bool json = false;
};

void AddEvalOptions(CLI::App& command, EvalOptions* options);
const char* AlignmentName(Alignment alignment);

// Both trajectories and what belongs together in them.
struct EvalInput {
  Trajectory reference;
  Trajectory estimate;
  std::vector<PosePair> pairs;
  bool by_time = true;
};

// Reads the files and associates them: by time when both have times, by index when both are KITTI files. One
// with and one without times is a usage error that says what to add.
absl::StatusOr<EvalInput> ReadEvalInput(const EvalOptions& options);

}  // namespace semmap::client
