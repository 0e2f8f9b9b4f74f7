#pragma once

#include <vector>

#include "slam/common/time.h"
#include "slam/geometry/se3.h"

namespace semmap {

// Where one camera (or body) was at one time. The map frame is whatever the trajectory's maker chose.
struct StampedPose {
  TimestampNs timestamp = 0;
  SE3 map_from_camera;
};

// Poses in the order of their file. KITTI pose files carry no times: there the timestamps are zero, `timed`
// is false and the position in the list is the frame number.
struct Trajectory {
  std::vector<StampedPose> poses;
  bool timed = true;

  size_t size() const { return poses.size(); }
  bool empty() const { return poses.empty(); }
};

// Metres travelled up to each pose; the first is 0. As long as the trajectory.
std::vector<double> DistancesAlong(const Trajectory& trajectory);

// Length of the polygon through all positions, metres.
double PathLength(const Trajectory& trajectory);

}  // namespace semmap
