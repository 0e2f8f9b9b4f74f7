#pragma once

#include <cstdint>

#include "client/town/lots.h"
#include "client/town/mesh.h"

namespace semmap::town {

// A house that fills the lot, in a style of its own.
void BuildHouse(const Lot& lot, uint64_t seed, MeshBuilder* mesh);

// What stands on a lot without a house that reaches the pavement: a garden, a yard, a car park, behind a
// fence, a wall or a hedge.
void BuildOpenLot(const Lot& lot, uint64_t seed, MeshBuilder* mesh);

// The share of lots that is left open.
bool IsOpenLot(const Lot& lot, uint64_t seed);

}  // namespace semmap::town
