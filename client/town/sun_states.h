#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "client/town/mesh.h"

namespace semmap::town {

// What the sun does to a surface that stands still; kept in Vertex::sun.
enum class SunState : uint8_t {
  kDark = 0,   // turned away, or in shadow all over
  kLit = 1,    // lit all over
  kMixed = 2,  // an edge of a shadow crosses it: the renderer has to look at each pixel
};

// The map of the shadows as the renderer drew it: the depth of what the sun sees first, 0 to 65535.
struct ShadowMap {
  int size = 0;
  std::vector<uint16_t> depth;  // rows of texels, the lowest first
  glm::mat4 texture_from_town{1.0F};
};

// Sets the state of every quad (four vertices in a row) of a mesh. Most surfaces of a street lie wholly in
// the light or in the shade, and looking that up once, here, saves the renderer the look at each pixel of
// each frame. Leaves are small: each takes the light of its middle.
void ClassifySun(const ShadowMap& map, const glm::vec3& sun, Mesh* mesh);

}  // namespace semmap::town
