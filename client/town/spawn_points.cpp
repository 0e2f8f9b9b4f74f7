#include "client/town/spawn_points.h"

#include <cmath>

namespace semmap::town {

std::vector<SpawnPoint> SpawnPoints(const RoadNetwork& network, int count) {
  double total = 0;
  for (const Lane& lane : network.lanes()) total += lane.path.length();
  const double step = total / count;
  std::vector<SpawnPoint> points;
  double next = step / 2;  // still to go on the lanes
  for (const Lane& lane : network.lanes()) {
    for (; next < lane.path.length() && static_cast<int>(points.size()) < count; next += step) {
      const glm::dvec2 tangent = lane.path.TangentAt(next);
      points.push_back({lane.id, lane.path.PointAt(next), std::atan2(tangent.y, tangent.x)});
    }
    next -= lane.path.length();
  }
  return points;
}

}  // namespace semmap::town
