#include "slam/evaluation/trajectory.h"

namespace semmap {

std::vector<double> DistancesAlong(const Trajectory& trajectory) {
  std::vector<double> distances;
  distances.reserve(trajectory.size());
  double travelled = 0;
  for (size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0) {
      travelled += (trajectory.poses[i].map_from_camera.translation() -
                    trajectory.poses[i - 1].map_from_camera.translation())
                       .norm();
    }
    distances.push_back(travelled);
  }
  return distances;
}

double PathLength(const Trajectory& trajectory) {
  return trajectory.empty() ? 0.0 : DistancesAlong(trajectory).back();
}

}  // namespace semmap
