#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/association.h"
#include "slam/evaluation/statistics.h"

namespace semmap {

// Relative pose error over segments of given lengths, as KITTI's odometry benchmark measures it (Geiger et
// al. 2012): from a start pose to the first pose more than `length` metres further along the reference,
//   error = estimated_motion^-1 * true_motion,
// its translation over the length in percent, its rotation angle over the length in degrees per metre.
struct SegmentRpeOptions {
  // Empty: KITTI's 100, 200, ... 800 m; on a reference shorter than 200 m a tenth of these, shorter than 20 m
  // a hundredth, so that short drives have a figure too. Lengths that do not fit are left out.
  std::vector<double> lengths_m;
  // Every how many poses a segment starts; 0: every 10th as KITTI, or every one when the lengths were
  // shortened.
  int step = 0;
  // Multiplies the estimate's translations: the scale of an alignment, for one camera.
  double estimate_scale = 1.0;
};

struct SegmentLengthError {
  double length_m = 0;
  size_t segments = 0;
  double translation_percent = 0;
  double rotation_deg_per_m = 0;
};

struct SegmentRpeResult {
  size_t segments = 0;
  // Means over all segments, as the benchmark ranks by.
  double translation_percent = 0;
  double rotation_deg_per_m = 0;
  std::vector<SegmentLengthError> by_length;
};

// INVALID_ARGUMENT for options that make no sense, FAILED_PRECONDITION when the path is too short for any
// length.
absl::StatusOr<SegmentRpeResult> ComputeSegmentRpe(const std::vector<PosePair>& pairs,
                                                   const SegmentRpeOptions& options);

// Relative pose error over a fixed interval, as TUM's tools measure it: drift per second or per so many
// frames. Each pair is a start; its end is the first pair at least `delta_s` (or `delta_frames` positions)
// later.
struct IntervalRpeOptions {
  double delta_s = 1.0;
  int delta_frames = 0;  // positive: used instead of delta_s, for trajectories without times
  double estimate_scale = 1.0;
};

struct IntervalRpeResult {
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
};

// As ComputeSegmentRpe.
absl::StatusOr<IntervalRpeResult> ComputeIntervalRpe(const std::vector<PosePair>& pairs,
                                                     const IntervalRpeOptions& options);

}  // namespace semmap
