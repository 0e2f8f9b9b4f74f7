#pragma once

#include <array>
#include <cstdint>

#include <glm/vec2.hpp>

#include "client/town/mesh.h"
#include "client/town/random.h"

namespace semmap::town {

enum class GroundFloor { kFlats, kShops, kPlinth };

// All choices that make one house unlike the next.
struct HouseStyle {
  Texture wall = Texture::kPlaster0;
  std::array<uint8_t, 3> wall_tint{255, 255, 255};
  std::array<uint8_t, 3> trim_tint{230, 226, 216};
  Texture windows = Texture::kWindows0;
  GroundFloor ground = GroundFloor::kFlats;
  int floors = 4;
  float ground_height = 3.8F;
  float floor_height = 3.1F;
  float window_width = 1.2F;
  float window_height = 1.7F;
  float bay_width = 2.7F;
  bool balconies = false;
  bool cornice = true;
  bool bands = false;      // a ledge below each floor
  bool surrounds = false;  // stone frames around windows
  bool awnings = false;
  bool pitched_roof = false;
  uint64_t seed = 0;

  float WallHeight() const { return ground_height + static_cast<float>(floors - 1) * floor_height; }
};

HouseStyle ChooseStyle(uint64_t seed, int house);

// One wall from p to q (p at the left hand of who stands before it), from `z0` up to the style's wall height,
// with windows, doors, shops, ledges, balconies, signs, pipes and graffiti.
void BuildStreetFacade(const HouseStyle& style, const glm::dvec2& p, const glm::dvec2& q, float z0,
                       Random* random, MeshBuilder* mesh);
// Flat windows in a plain wall.
void BuildRearFacade(const HouseStyle& style, const glm::dvec2& p, const glm::dvec2& q, float z0,
                     Random* random, MeshBuilder* mesh);
// A blank wall, now and then with a large painted advertisement.
void BuildPartyWall(const HouseStyle& style, const glm::dvec2& p, const glm::dvec2& q, float z0,
                    Random* random, MeshBuilder* mesh);

}  // namespace semmap::town
