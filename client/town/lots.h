#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

#include "client/town/road_network.h"

namespace semmap::town {

inline constexpr double kLotDepth = 12.0;

enum class BlockKind { kBuilt, kPark, kPlaza };

// One wall line of a lot's outline and what it looks at.
enum class EdgeKind { kStreet, kCorner, kRear, kParty };

// A piece of land at the pavement. The outline runs counter-clockwise; edge i goes from corner i to the next.
struct Lot {
  int id = 0;
  std::vector<glm::dvec2> corners;
  std::vector<EdgeKind> edges;
  BlockKind block = BlockKind::kBuilt;
};

// What the block to the north-east of junction (column, row) is; outside of the grid everything is built.
BlockKind BlockAt(const RoadNetwork& network, uint64_t seed, int column, int row);

// All land along the pavements, without overlaps, none in the way of the canal.
std::vector<Lot> DivideLots(const RoadNetwork& network, uint64_t seed);

}  // namespace semmap::town
