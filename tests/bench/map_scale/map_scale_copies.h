#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "absl/status/status.h"
#include "slam/features/descriptor.h"
#include "tests/bench/map_scale/map_scale_options.h"

namespace semmap::bench {

// Where copy `index` of the drive lies beside the first, which is index 0, in the map frame.
Eigen::Vector3d ShiftOfCopy(int index);
// What all descriptors of the copy differ by: 112 of 256 bits at random, and none of the first. Within a
// copy, distances are as in the drive. With fewer bits (37 were tried) guided search, which knows where to
// look, still finds the corners of one copy in another, and every place is rightly held to be ambiguous.
Descriptor MaskOfCopy(int index);
Descriptor Masked(const Descriptor& descriptor, const Descriptor& mask);

// Lays copies of the drive side by side in the map "large" until it is as large as the options ask for,
// through MapStore::Apply, each a session of its own. Does nothing when that was done before.
absl::Status MakeLargeMap(const MapScaleOptions& options);

}  // namespace semmap::bench
