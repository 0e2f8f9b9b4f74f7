#pragma once

#include "absl/status/status.h"
#include "tests/bench/map_scale/map_scale_options.h"

namespace semmap::bench {

// Drives, and stores the map "drive" and every so-manieth frame as a picture named by its sequence number
// (with `r` behind it for the right eye). Does nothing when that was done before.
absl::Status MakeDrive(const MapScaleOptions& options);

}  // namespace semmap::bench
