#include "client/town/house_builder.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "client/town/facade.h"
#include "client/town/facade_frame.h"
#include "client/town/random.h"
#include "client/town/street_view.h"
#include "client/town/vegetation.h"

namespace semmap::town {
namespace {

constexpr uint64_t kHousePurpose = 71;
constexpr uint64_t kOpenPurpose = 72;

glm::dvec2 CentreOf(const Lot& lot) {
  glm::dvec2 sum(0, 0);
  for (const glm::dvec2& corner : lot.corners) sum += corner;
  return sum / static_cast<double>(lot.corners.size());
}

// A fan over the outline at height z.
void Cover(const std::vector<glm::dvec2>& corners, double z, const Surface& surface, MeshBuilder* mesh) {
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    mesh->Triangle(Lift(corners[0], z), Lift(corners[i], z), Lift(corners[i + 1], z), surface);
  }
}

void BuildChimneys(const Lot& lot, float roof, Random* random, MeshBuilder* mesh) {
  const int count = random->Integer(1, 3);
  for (int i = 0; i < count; ++i) {
    const glm::dvec2 at = CentreOf(lot) + glm::dvec2(random->Uniform(-3, 3), random->Uniform(-3, 3));
    const float height = random->Float(1.2, 2.6);
    mesh->Box(Lift(at, roof), {1, 0}, {0.9F, 0.6F, height},
              MakeSurface(Texture::kBrick2, ClassId::kBuilding));
    mesh->Box(Lift(at, roof + height), {1, 0}, {1.1F, 0.8F, 0.15F},
              MakeSurface(Texture::kConcrete1, ClassId::kBuilding));
  }
}

void BuildFlatRoof(const Lot& lot, const HouseStyle& style, Random* random, MeshBuilder* mesh) {
  const float top = style.WallHeight();
  constexpr float kParapet = 0.7F;
  Cover(lot.corners, top, MakeSurface(Texture::kRoofFelt, ClassId::kBuilding), mesh);
  const Surface wall = MakeSurface(style.wall, ClassId::kBuilding, style.wall_tint);
  const Surface coping = MakeSurface(Texture::kConcrete1, ClassId::kBuilding);
  const size_t n = lot.corners.size();
  for (size_t i = 0; i < n; ++i) {
    const WallFrame frame(lot.corners[i], lot.corners[(i + 1) % n]);
    frame.Rect(mesh, 0, top, frame.width(), top + kParapet, 0, wall);
    const WallFrame inside(lot.corners[(i + 1) % n], lot.corners[i]);
    inside.Rect(mesh, 0, top, inside.width(), top + kParapet, 0.3F, wall);
    frame.Ledge(mesh, 0, top + kParapet, frame.width(), top + kParapet + 0.1F, 0.08F, coping);
    mesh->Quad(frame.At(0, top + kParapet + 0.1F, 0), frame.At(frame.width(), top + kParapet + 0.1F, 0),
               frame.At(frame.width(), top + kParapet + 0.1F, -0.35F),
               frame.At(0, top + kParapet + 0.1F, -0.35F), coping);
  }
  BuildChimneys(lot, top, random, mesh);
}

// A gable roof whose ridge runs along the street.
void BuildPitchedRoof(const Lot& lot, const HouseStyle& style, Random* random, MeshBuilder* mesh) {
  const float top = style.WallHeight();
  const float rise = random->Float(2.8, 4.2);
  const auto& c = lot.corners;
  const glm::dvec2 left = (c[0] + c[3]) * 0.5;
  const glm::dvec2 right = (c[1] + c[2]) * 0.5;
  const Surface tiles = MakeSurface(random->Chance(0.6) ? Texture::kRoofTiles : Texture::kSlate,
                                    ClassId::kBuilding, Shade({255, 255, 255}, random->Uniform(0.7, 1)));
  const glm::dvec2 out = glm::normalize(c[0] - c[3]) * 0.4;
  const float eaves = top - 0.1F;
  mesh->Quad(Lift(c[0] + out, eaves), Lift(c[1] + out, eaves), Lift(right, top + rise),
             Lift(left, top + rise), tiles);
  mesh->Quad(Lift(c[2] - out, eaves), Lift(c[3] - out, eaves), Lift(left, top + rise),
             Lift(right, top + rise), tiles);
  const Surface gable = MakeSurface(style.wall, ClassId::kBuilding, style.wall_tint);
  mesh->Triangle(Lift(c[1], top), Lift(c[2], top), Lift(right, top + rise), gable);
  mesh->Triangle(Lift(c[3], top), Lift(c[0], top), Lift(left, top + rise), gable);
  BuildChimneys(lot, top + rise * 0.4F, random, mesh);
  const WallFrame front(c[0], c[1]);
  const Surface window = MakeSurface(style.windows, ClassId::kBuilding);
  for (float x = 2.2F; x < front.width() - 2.0F; x += 3.6F) {  // dormers
    const glm::vec3 base = front.At(x, top + 0.35F, -1.3F);
    mesh->Box(base, front.along(), {1.5F, 2.4F, 1.6F}, tiles);
    const CellUv cell = CellOf(random->Below(16), 4, 4);
    front.RectUv(mesh, x - 0.6F, top + 0.55F, x + 0.6F, top + 1.85F, -0.08F, window, cell.low, cell.high);
  }
}

Surface BoundarySurface(Random* random) {
  static constexpr std::array<Texture, 5> kWalls = {Texture::kRubble, Texture::kBrick0, Texture::kConcrete1,
                                                    Texture::kPlasterBroken, Texture::kAshlar1};
  return MakeSurface(kWalls[static_cast<size_t>(random->Below(5))], ClassId::kWall,
                     Shade({255, 255, 255}, random->Uniform(0.75, 1)));
}

void BuildBoundaryWall(const WallFrame& frame, Random* random, MeshBuilder* mesh) {
  const Surface wall = BoundarySurface(random);
  const float height = random->Float(1.3, 2.6);
  frame.Ledge(mesh, 0, 0, frame.width(), height, 0.0F, wall);
  const WallFrame back(glm::dvec2(frame.At(frame.width(), 0, -0.3F)), glm::dvec2(frame.At(0, 0, -0.3F)));
  back.Rect(mesh, 0, 0, back.width(), height, 0, wall);
  mesh->Quad(frame.At(0, height, 0.06F), frame.At(frame.width(), height, 0.06F),
             frame.At(frame.width(), height, -0.36F), frame.At(0, height, -0.36F),
             MakeSurface(Texture::kConcrete0, ClassId::kWall));
  for (float x = 0; x <= frame.width(); x += 3.2F) {
    mesh->Box(frame.At(std::min(x + 0.2F, frame.width() - 0.2F), 0, -0.15F), frame.along(),
              {0.45F, 0.5F, height + 0.25F}, MakeSurface(Texture::kAshlar1, ClassId::kWall));
  }
  if (!random->Chance(0.75)) return;
  const float width = random->Float(1.5, 3.0);
  const float x = random->Float(0.5, std::max(0.6, static_cast<double>(frame.width() - width)));
  const CellUv cell = CellOf(random->Below(16), 4, 4);
  mesh->CutQuad({frame.At(x, 0.15F, 0.02F), frame.At(x + width, 0.15F, 0.02F),
                 frame.At(x + width, 1.3F, 0.02F), frame.At(x, 1.3F, 0.02F)},
                cell.low, cell.high, frame.out(), MakeSurface(Texture::kGraffiti, ClassId::kWall));
}

void BuildBoundary(const WallFrame& frame, Random* random, MeshBuilder* mesh) {
  const double kind = random->Uniform();
  if (kind < 0.45) return BuildBoundaryWall(frame, random, mesh);
  if (kind < 0.85) {
    static constexpr std::array<Texture, 3> kFences = {Texture::kFencePickets, Texture::kFenceBars,
                                                       Texture::kFenceMesh};
    return BuildFence(frame, kFences[static_cast<size_t>(random->Below(3))], random->Float(1.2, 2.0), random,
                      mesh);
  }
  BuildHedge(frame, random->Float(1.0, 1.7), mesh);
}

}  // namespace

bool IsOpenLot(const Lot& lot, uint64_t seed) {
  if (lot.block != BlockKind::kBuilt) return true;
  if (lot.corners.size() != 4) return false;
  return Random(seed, kOpenPurpose, static_cast<uint64_t>(lot.id)).Chance(0.2);
}

void BuildHouse(const Lot& lot, uint64_t seed, MeshBuilder* mesh) {
  Random random(seed, kHousePurpose, static_cast<uint64_t>(lot.id));
  HouseStyle style = ChooseStyle(seed, lot.id);
  mesh->SetTextureShift({random.Float(0, 37), random.Float(0, 37)});
  if (lot.corners.size() != 4) style.pitched_roof = false;
  const size_t n = lot.corners.size();
  for (size_t i = 0; i < n; ++i) {
    const glm::dvec2& p = lot.corners[i];
    const glm::dvec2& q = lot.corners[(i + 1) % n];
    if (lot.edges[i] == EdgeKind::kStreet || lot.edges[i] == EdgeKind::kCorner) {
      BuildStreetFacade(style, p, q, 0, &random, mesh);
    } else if (lot.edges[i] == EdgeKind::kRear) {
      BuildRearFacade(style, p, q, 0, &random, mesh);
    } else {
      BuildPartyWall(style, p, q, 0, &random, mesh);
    }
  }
  if (style.pitched_roof) {
    BuildPitchedRoof(lot, style, &random, mesh);
  } else {
    BuildFlatRoof(lot, style, &random, mesh);
  }
  mesh->SetTextureShift({0, 0});
}

void BuildOpenLot(const Lot& lot, uint64_t seed, MeshBuilder* mesh) {
  Random random(seed, kOpenPurpose, static_cast<uint64_t>(lot.id), 1);
  mesh->SetTextureShift({random.Float(0, 37), random.Float(0, 37)});
  const bool plaza = lot.block == BlockKind::kPlaza;
  const bool yard = plaza || (lot.block == BlockKind::kBuilt && random.Chance(0.4));
  Cover(lot.corners, plaza ? kKerbHeight : 0.05,
        yard ? MakeSurface(plaza ? Texture::kSetts : Texture::kGravel, ClassId::kGround, {236, 226, 214})
             : MakeSurface(Texture::kGrass, ClassId::kTerrain),
        mesh);
  if (!plaza) {
    for (size_t i = 0; i < lot.corners.size(); ++i) {
      if (lot.edges[i] == EdgeKind::kParty || lot.edges[i] == EdgeKind::kRear) continue;
      BuildBoundary(WallFrame(lot.corners[i], lot.corners[(i + 1) % lot.corners.size()]), &random, mesh);
    }
  }
  const int trees = plaza ? (random.Chance(0.4) ? 1 : 0) : random.Integer(1, 3);
  for (int i = 0; i < trees; ++i) {
    const glm::dvec2 at = CentreOf(lot) + glm::dvec2(random.Uniform(-3.0, 3.0), random.Uniform(-3.0, 3.0));
    BuildTree(Lift(at, 0.05), random.Float(5, 10), &random, mesh);
  }
  const int bushes = yard ? 1 : 4;
  for (int i = 0; i < bushes; ++i) {
    const glm::dvec2 at = CentreOf(lot) + glm::dvec2(random.Uniform(-4.0, 4.0), random.Uniform(-4.0, 4.0));
    BuildBush(Lift(at, 0.05), random.Float(0.7, 1.5), &random, mesh);
  }
  mesh->SetTextureShift({0, 0});
}

}  // namespace semmap::town
