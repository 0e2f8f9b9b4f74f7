#pragma once

#include <cstdint>

#include "client/town/mesh.h"

namespace semmap::town {

// One vehicle of ShapeOf(kind), its colour and wheels drawn from `look`. Origin on the ground below the
// middle, x forwards, y left, z up.
void BuildVehicle(int kind, uint64_t look, MeshBuilder* mesh);

}  // namespace semmap::town
