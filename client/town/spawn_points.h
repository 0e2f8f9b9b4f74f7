#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "client/town/road_network.h"

namespace semmap::town {

// A place on a lane where a vehicle may be set down, heading with the traffic.
struct SpawnPoint {
  int lane = 0;
  glm::dvec2 position{0, 0};
  double heading = 0;
};

// `count` points spread evenly over the length of all lanes.
std::vector<SpawnPoint> SpawnPoints(const RoadNetwork& network, int count);

}  // namespace semmap::town
