#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "client/town/mesh.h"
#include "client/town/road_network.h"

namespace semmap::town {

// One box of lights; which disc shines is the traffic's to say.
struct SignalHead {
  int junction = 0;
  int side = 0;  // of the junction that it speaks to
  bool for_pedestrians = false;
  glm::vec3 position{0};  // middle of the housing's front
  glm::vec2 facing{1, 0};
};

// Lamps, trees, signs, bins, benches, bus stops, parked vehicles and loose things along the streets.
void BuildStreetFurniture(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh);

// Posts of the traffic lights; returns the heads that they carry.
std::vector<SignalHead> BuildSignals(const RoadNetwork& network, MeshBuilder* mesh);

}  // namespace semmap::town
