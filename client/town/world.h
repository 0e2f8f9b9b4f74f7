#pragma once

#include <cstdint>
#include <vector>

#include "client/town/furniture.h"
#include "client/town/mesh.h"
#include "client/town/road_network.h"

namespace semmap::town {

// All that does not move in one town, made from its seed. About 60 MB; immutable, so that several renderers
// and simulations may share it between threads.
class World {
 public:
  World(const NetworkConfig& config, uint64_t seed);

  uint64_t seed() const { return seed_; }
  const RoadNetwork& network() const { return network_; }
  const MeshBuilder& mesh() const { return mesh_; }
  const std::vector<SignalHead>& signal_heads() const { return signal_heads_; }

 private:
  uint64_t seed_;
  RoadNetwork network_;
  MeshBuilder mesh_;
  std::vector<SignalHead> signal_heads_;
};

}  // namespace semmap::town
