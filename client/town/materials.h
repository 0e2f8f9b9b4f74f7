#pragma once

#include <cstdint>

namespace semmap::town {

// Layers of the texture array. What each shows is painted in textures_*.cpp.
enum class Texture : uint8_t {
  kAsphalt0,
  kAsphalt1,
  kAsphalt2,
  kPavingSlabs0,
  kPavingSlabs1,
  kSetts,
  kPaint,
  kBrick0,
  kBrick1,
  kBrick2,
  kPlaster0,
  kPlaster1,
  kPlaster2,
  kPlasterBroken,
  kAshlar0,
  kAshlar1,
  kConcrete0,
  kConcrete1,
  kPanels,
  kTiles,
  kRubble,
  kWood,
  kMetal,
  kCorrugated,
  kRoofTiles,
  kSlate,
  kRoofFelt,
  kGrass,
  kSoil,
  kGravel,
  kBallast,
  kWater,
  kBark,
  kHedge,
  kLeaves0,
  kLeaves1,
  kLeaves2,
  kBush,
  kWindows0,  // 4 x 4 windows each
  kWindows1,
  kWindows2,
  kWindows3,
  kWindows4,
  kWindows5,
  kDoors,   // 4 x 2 doors
  kShops0,  // 2 shop fronts each, one above the other
  kShops1,
  kShops2,
  kShops3,
  kShops4,
  kShops5,
  kShops6,
  kShops7,
  kShopSigns0,  // 8 boards each, one above the other
  kShopSigns1,
  kShopSigns2,
  kShopSigns3,
  kPosters0,  // 4 x 2 posters
  kPosters1,
  kGraffiti,      // 4 x 4, cut out
  kTrafficSigns,  // 4 x 4, cut out
  kRoadArrows,    // 4 x 4, cut out: arrows, manholes, patches
  kFencePickets,  // cut out
  kFenceBars,
  kFenceMesh,
  kRailing,
  kGuardRail,
  kTruss,
  kCar0,  // one vehicle's side, front, rear and top each
  kCar1,
  kCar2,
  kCar3,
  kCar4,
  kVan,
  kBus,
  kWheels,
  kCloth0,  // 4 x 4 people's clothes
  kCloth1,
  kFaces,
  kLights,  // lamps, signal discs, number plates
  kBins,
  kSky,
  kCount,
};

inline constexpr int kTextureCount = static_cast<int>(Texture::kCount);
inline constexpr int kTextureSize = 512;  // texels, both ways

// Metres that one tile of a repeating texture covers.
float TileMetres(Texture texture);

}  // namespace semmap::town
