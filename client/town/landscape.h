#pragma once

#include <cstdint>

#include "client/town/mesh.h"
#include "client/town/road_network.h"

namespace semmap::town {

// The ground under everything, the canal with its bridges, footbridges, guard rails at bends, the park, the
// plaza and the hills on the horizon.
void BuildLandscape(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh);

// The dome of the sky around the origin, radius 1; drawn without depth around the camera.
void BuildSkyDome(MeshBuilder* mesh);

}  // namespace semmap::town
