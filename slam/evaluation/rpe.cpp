#include "slam/evaluation/rpe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slam/common/status_macros.h"

namespace semmap {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr int kKittiLengths = 8;
constexpr double kKittiUnitM = 100.0;
constexpr int kKittiStep = 10;
constexpr double kSmallestUnitM = 0.1;

struct Lengths {
  std::vector<double> metres;
  int step = 1;
};

std::vector<double> ReferenceDistances(const std::vector<PosePair>& pairs) {
  Trajectory reference;
  for (const PosePair& pair : pairs) reference.poses.push_back({pair.timestamp, pair.reference});
  return DistancesAlong(reference);
}

Lengths ChooseLengths(const SegmentRpeOptions& options, double path_m) {
  Lengths lengths{options.lengths_m, options.step};
  double unit = kKittiUnitM;
  if (lengths.metres.empty()) {
    while (path_m < 2 * unit && unit > kSmallestUnitM) unit /= 10;
    for (int i = 1; i <= kKittiLengths; ++i) lengths.metres.push_back(i * unit);
  }
  if (lengths.step == 0) lengths.step = unit < kKittiUnitM ? 1 : kKittiStep;
  return lengths;
}

absl::Status ValidateSegments(const SegmentRpeOptions& options) {
  const bool lengths_ok = std::all_of(options.lengths_m.begin(), options.lengths_m.end(),
                                      [](double length) { return std::isfinite(length) && length > 0; });
  if (!lengths_ok) return absl::InvalidArgumentError("segment lengths must be positive");
  if (options.step < 0) return absl::InvalidArgumentError("the step between segments must be positive");
  if (!(options.estimate_scale > 0)) return absl::InvalidArgumentError("the scale must be positive");
  return absl::OkStatus();
}

SE3 MotionError(const PosePair& start, const PosePair& end, double estimate_scale) {
  const SE3 true_motion = start.reference.Inverse() * end.reference;
  const SE3 motion = start.estimate.Inverse() * end.estimate;
  const SE3 estimated_motion(motion.rotation(), estimate_scale * motion.translation());
  return estimated_motion.Inverse() * true_motion;
}

SegmentLengthError MeasureLength(const std::vector<PosePair>& pairs, const std::vector<double>& distances,
                                 double length, int step, double estimate_scale) {
  SegmentLengthError sum{length, 0, 0, 0};
  for (size_t first = 0; first < pairs.size(); first += static_cast<size_t>(step)) {
    const auto last = std::upper_bound(distances.begin() + static_cast<std::ptrdiff_t>(first),
                                       distances.end(), distances[first] + length);
    if (last == distances.end()) break;
    const auto& end = pairs[static_cast<size_t>(last - distances.begin())];
    const SE3 error = MotionError(pairs[first], end, estimate_scale);
    ++sum.segments;
    sum.translation_percent += 100.0 * error.translation().norm() / length;
    sum.rotation_deg_per_m += kDegrees * error.RotationAngle() / length;
  }
  return sum;
}

void Divide(double count, double* translation, double* rotation) {
  *translation /= count;
  *rotation /= count;
}

// The first pair at least the interval later than `start`; the number of pairs when there is none.
size_t EndOfInterval(const std::vector<PosePair>& pairs, size_t start, const IntervalRpeOptions& options) {
  if (options.delta_frames > 0) return start + static_cast<size_t>(options.delta_frames);
  const TimestampNs target = pairs[start].timestamp + FromSeconds(options.delta_s);
  const auto end =
      std::lower_bound(pairs.begin() + static_cast<std::ptrdiff_t>(start), pairs.end(), target,
                       [](const PosePair& pair, TimestampNs time) { return pair.timestamp < time; });
  return static_cast<size_t>(end - pairs.begin());
}

}  // namespace

absl::StatusOr<SegmentRpeResult> ComputeSegmentRpe(const std::vector<PosePair>& pairs,
                                                   const SegmentRpeOptions& options) {
  SEMMAP_RETURN_IF_ERROR(ValidateSegments(options));
  const std::vector<double> distances = ReferenceDistances(pairs);
  const Lengths lengths = ChooseLengths(options, distances.empty() ? 0.0 : distances.back());
  SegmentRpeResult result;
  for (const double length : lengths.metres) {
    SegmentLengthError sum = MeasureLength(pairs, distances, length, lengths.step, options.estimate_scale);
    if (sum.segments == 0) continue;
    result.segments += sum.segments;
    result.translation_percent += sum.translation_percent;
    result.rotation_deg_per_m += sum.rotation_deg_per_m;
    Divide(static_cast<double>(sum.segments), &sum.translation_percent, &sum.rotation_deg_per_m);
    result.by_length.push_back(sum);
  }
  if (result.segments == 0)
    return absl::FailedPreconditionError("the path is too short for any segment length");
  Divide(static_cast<double>(result.segments), &result.translation_percent, &result.rotation_deg_per_m);
  return result;
}

absl::StatusOr<IntervalRpeResult> ComputeIntervalRpe(const std::vector<PosePair>& pairs,
                                                     const IntervalRpeOptions& options) {
  if (options.delta_frames < 0 || (options.delta_frames == 0 && !(options.delta_s > 0)) ||
      !(options.estimate_scale > 0)) {
    return absl::InvalidArgumentError("the interval and the scale must be positive");
  }
  std::vector<double> translations;
  std::vector<double> rotations;
  for (size_t start = 0; start < pairs.size(); ++start) {
    const size_t end = EndOfInterval(pairs, start, options);
    if (end >= pairs.size()) break;
    const SE3 error = MotionError(pairs[start], pairs[end], options.estimate_scale);
    translations.push_back(error.translation().norm());
    rotations.push_back(kDegrees * error.RotationAngle());
  }
  if (translations.empty())
    return absl::FailedPreconditionError("the trajectory is shorter than the interval");
  return IntervalRpeResult{Summarize(translations), Summarize(rotations)};
}

}  // namespace semmap
