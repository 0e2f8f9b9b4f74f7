#pragma once

#include <array>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/ate.h"

namespace semmap {

// Mean absolute percentage error of the position, equation (1) of Podtikhov and Saveliev, "Ground Mobile
// Robot Localization Algorithm Based on Semantic Information from the Urban Environment":
//
//   MAPE([x, y], [x^, y^]) = MEAN( 100 % / n * sum_i [|x_i - x^_i|, |y_i - y^_i|] / [|x_i|, |y_i|] )
//
// As printed, the prediction reads "[x^ + y^]" and the denominator "[|x_i|, |x_i|]"; both are taken for
// slips. Our reading:
// - x and y are the two axes of the ground plane in the reference's own frame (CARLA's x and y, a KITTI
// camera's x
//   and z): the two axes along which the reference extends furthest, unless the caller names them.
// - The division is by component. The sum gives one percentage for each axis, and MEAN is the mean of the
// two.
// - The estimate is aligned first (the paper: Horn's algorithm with scale).
// - A true coordinate near zero makes its quotient meaningless (the first pose of a KITTI drive is the
// origin), about
//   which the paper is silent: quotients whose denominator is below `min_denominator_m` are left out and
//   counted.
// The figure depends on where the origin is, so it compares runs over one drive, not drives.
struct MapeOptions {
  Alignment alignment = Alignment::kSim3;
  double min_denominator_m = 1.0;
  // 0, 1, 2 for x, y, z.
  std::optional<std::array<int, 2>> axes;
};

struct MapeResult {
  double mape_percent = 0;
  std::array<int, 2> axes{};
  std::array<double, 2> axis_percent{};
  std::array<size_t, 2> used{};  // quotients that entered, for each axis
  std::array<size_t, 2> left_out{};
  Sim3 reference_from_estimate;
  // Distance in the ground plane for each pair, metres: the paper's figure 4.
  std::vector<double> errors_m;
};

// The two axes with the greatest extent of the reference, in growing order.
std::array<int, 2> GroundAxes(const std::vector<PosePair>& pairs);

// INVALID_ARGUMENT for bad options or an undetermined alignment, FAILED_PRECONDITION when on one axis no
// coordinate is far enough from zero.
absl::StatusOr<MapeResult> ComputeMape(const std::vector<PosePair>& pairs, const MapeOptions& options);

}  // namespace semmap
