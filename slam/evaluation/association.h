#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/trajectory.h"

namespace semmap {

// The true and the estimated pose of one instant, each in its own map frame.
struct PosePair {
  TimestampNs timestamp = 0;  // of the estimate; 0 when neither trajectory has times
  size_t reference_index = 0;
  size_t estimate_index = 0;
  SE3 reference;
  SE3 estimate;
};

constexpr double kDefaultMaxTimeDifferenceS = 0.02;

// Pairs poses nearest in time, each used at most once, the closest pairs first (as TUM's tools do), ordered
// by time. A pose without a partner within `max_difference_s` stays out. INVALID_ARGUMENT when a trajectory
// has no times, FAILED_PRECONDITION when nothing matches.
absl::StatusOr<std::vector<PosePair>> AssociateByTime(const Trajectory& reference, const Trajectory& estimate,
                                                      double max_difference_s = kDefaultMaxTimeDifferenceS);

// Pairs pose i with pose i; INVALID_ARGUMENT unless both have the same number, since a hole would shift the
// rest.
absl::StatusOr<std::vector<PosePair>> AssociateByIndex(const Trajectory& reference,
                                                       const Trajectory& estimate);

// A pair of positions in two lists of times that both grow.
struct TimeMatch {
  size_t first = 0;
  size_t second = 0;
};
// The matching behind AssociateByTime, also for image lists. Each entry competes with at most a few
// neighbours in time, so that the work is bounded whatever the difference allowed.
std::vector<TimeMatch> MatchTimes(const std::vector<TimestampNs>& first,
                                  const std::vector<TimestampNs>& second, double max_difference_s);

}  // namespace semmap
