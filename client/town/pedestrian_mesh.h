#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>

#include "client/town/mesh.h"

namespace semmap::town {

// The limbs of one person, each a mesh in the frame of its own joint (x forwards, y left, z up; the limb
// hangs down from the origin), for a height of 1.75 m.
enum class Limb { kBody, kHead, kThighLeft, kThighRight, kShinLeft, kShinRight, kArmLeft, kArmRight };
inline constexpr int kLimbs = 8;

// Meshes by Limb; clothes, skin and hair drawn from `look`.
std::vector<MeshBuilder> BuildPerson(uint64_t look);

// Joint frames in the person's frame (origin at the feet) while walking: `travelled` metres into the walk,
// `stride` between 0 (standing) and 1 (full steps).
std::vector<glm::mat4> WalkingPose(double travelled, double stride);

}  // namespace semmap::town
