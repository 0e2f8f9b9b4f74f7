#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/association.h"
#include "slam/evaluation/statistics.h"

namespace semmap {

enum class Alignment {
  kNone,  // both trajectories are in one frame already
  kSe3,   // rotation and translation: for sensors that know the scale
  kSim3,  // and scale: for one camera
};

std::optional<Alignment> ParseAlignment(std::string_view name);  // "none", "se3", "sim3"

// Absolute trajectory error (Sturm et al. 2012, "A Benchmark for the Evaluation of RGB-D SLAM Systems",
// section IV.B): distance between the true and the aligned estimated position of each pair, metres.
struct AteResult {
  ErrorStatistics translation_m;
  // The alignment found: reference_from_estimate * point_in_estimate is in the reference's frame.
  Sim3 reference_from_estimate;
  // One per pair, in their order.
  std::vector<double> errors_m;
};

// INVALID_ARGUMENT for no pairs, and where the pairs do not determine the alignment (fewer than 3, all in
// line).
absl::StatusOr<Sim3> AlignTrajectory(const std::vector<PosePair>& pairs, Alignment alignment);
absl::StatusOr<AteResult> ComputeAte(const std::vector<PosePair>& pairs, Alignment alignment);

}  // namespace semmap
