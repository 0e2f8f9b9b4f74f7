#include "slam/evaluation/mape.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap {
namespace {

constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};

absl::Status ValidateOptions(const MapeOptions& options) {
  if (!(options.min_denominator_m > 0) || !std::isfinite(options.min_denominator_m)) {
    return absl::InvalidArgumentError("the smallest denominator must be positive");
  }
  if (!options.axes) return absl::OkStatus();
  const auto [first, second] = *options.axes;
  if (first < 0 || first > 2 || second < 0 || second > 2 || first == second) {
    return absl::InvalidArgumentError("the axes must be two different ones of x, y, z");
  }
  return absl::OkStatus();
}

// Mean percentage along one axis of the result.
absl::Status MeasureAxis(const std::vector<PosePair>& pairs, const MapeOptions& options, size_t which,
                         MapeResult* result) {
  const int axis = result->axes[which];
  double sum = 0;
  for (const PosePair& pair : pairs) {
    const double truth = pair.reference.translation()[axis];
    if (std::abs(truth) < options.min_denominator_m) continue;
    const double estimate = (result->reference_from_estimate * pair.estimate.translation())[axis];
    sum += 100.0 * std::abs(truth - estimate) / std::abs(truth);
    ++result->used[which];
  }
  result->left_out[which] = pairs.size() - result->used[which];
  if (result->used[which] == 0) {
    return absl::FailedPreconditionError(absl::StrCat("along axis ", kAxisNames[static_cast<size_t>(axis)],
                                                      " no true coordinate is ", options.min_denominator_m,
                                                      " m or more from zero"));
  }
  result->axis_percent[which] = sum / static_cast<double>(result->used[which]);
  return absl::OkStatus();
}

double GroundDistance(const PosePair& pair, const MapeResult& result) {
  const Eigen::Vector3d difference =
      pair.reference.translation() - result.reference_from_estimate * pair.estimate.translation();
  return std::hypot(difference[result.axes[0]], difference[result.axes[1]]);
}

}  // namespace

std::array<int, 2> GroundAxes(const std::vector<PosePair>& pairs) {
  if (pairs.empty()) return {0, 1};
  Eigen::Vector3d low = pairs.front().reference.translation();
  Eigen::Vector3d high = low;
  for (const PosePair& pair : pairs) {
    low = low.cwiseMin(pair.reference.translation());
    high = high.cwiseMax(pair.reference.translation());
  }
  int smallest = 0;
  (high - low).minCoeff(&smallest);
  return {smallest == 0 ? 1 : 0, smallest == 2 ? 1 : 2};
}

absl::StatusOr<MapeResult> ComputeMape(const std::vector<PosePair>& pairs, const MapeOptions& options) {
  SEMMAP_RETURN_IF_ERROR(ValidateOptions(options));
  MapeResult result;
  SEMMAP_ASSIGN_OR_RETURN(result.reference_from_estimate, AlignTrajectory(pairs, options.alignment));
  result.axes = options.axes.value_or(GroundAxes(pairs));
  SEMMAP_RETURN_IF_ERROR(MeasureAxis(pairs, options, 0, &result));
  SEMMAP_RETURN_IF_ERROR(MeasureAxis(pairs, options, 1, &result));
  result.mape_percent = 0.5 * (result.axis_percent[0] + result.axis_percent[1]);
  for (const PosePair& pair : pairs) result.errors_m.push_back(GroundDistance(pair, result));
  return result;
}

}  // namespace semmap
