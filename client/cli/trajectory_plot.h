#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "slam/evaluation/association.h"
#include "slam/geometry/se3.h"

namespace semmap::client {

// What is drawn; references must live during the call.
struct TrajectoryPlot {
  const Trajectory& reference;
  const Trajectory& estimate;
  const std::vector<PosePair>& pairs;
  Sim3 reference_from_estimate;
  const std::vector<double>& errors_m;  // one for each pair
  bool by_time = true;                  // else the error is drawn over the frame number
  std::string title;
};

// Draws both trajectories from above (along the axis of least extent, in the reference's frame) and the error
// over time below, to a PNG. UNAVAILABLE when the file cannot be written.
absl::Status WriteTrajectoryPlot(const std::string& path, const TrajectoryPlot& plot);

}  // namespace semmap::client
