#pragma once

#include <span>

#include <Eigen/Core>

#include "absl/status/statusor.h"
#include "slam/geometry/se3.h"

namespace semmap {

// The similarity (scale 1 unless with_scale) that minimizes sum |target[i] - T * source[i]|^2, in closed form
// (Umeyama 1991, equations 40-42; Horn 1987 solves the same problem by quaternions). Never a reflection.
// INVALID_ARGUMENT for different sizes, fewer than 3 pairs, values that are not finite, and points all on one
// line (or in one place), which leave the rotation open.
absl::StatusOr<Sim3> AlignPoints(std::span<const Eigen::Vector3d> source,
                                 std::span<const Eigen::Vector3d> target, bool with_scale);

}  // namespace semmap
