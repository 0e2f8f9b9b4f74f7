#pragma once

#include <cstdint>

#include "client/town/mesh.h"
#include "client/town/road_network.h"

namespace semmap::town {

// Carriageways, kerbs, pavements, the tram's track bed and everything painted on the road.
void BuildStreets(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh);

}  // namespace semmap::town
