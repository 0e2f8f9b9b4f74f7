#pragma once

#include "client/town/facade_frame.h"
#include "client/town/mesh.h"
#include "client/town/random.h"

namespace semmap::town {

// A broad-leaved tree of the given height, metres: trunk, boughs, and a crown of leaf sprays.
void BuildTree(const glm::vec3& foot, float height, Random* random, MeshBuilder* mesh);
void BuildBush(const glm::vec3& foot, float height, Random* random, MeshBuilder* mesh);
// Along a wall line, at the line itself.
void BuildHedge(const WallFrame& frame, float height, MeshBuilder* mesh);
void BuildFence(const WallFrame& frame, Texture texture, float height, Random* random, MeshBuilder* mesh);

}  // namespace semmap::town
