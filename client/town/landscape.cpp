#include "client/town/landscape.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "client/town/facade_frame.h"
#include "client/town/lots.h"
#include "client/town/props.h"
#include "client/town/random.h"
#include "client/town/street_view.h"
#include "client/town/vegetation.h"

namespace semmap::town {
namespace {

constexpr uint64_t kLandscapeStream = 81;
constexpr double kGroundLevel = -0.12;
constexpr double kWaterLevel = -2.2;
constexpr double kRim = 130.0;  // the ground reaches this far beyond the outer junctions
constexpr double kTile = 24.0;

class LandscapeBuilder {
 public:
  LandscapeBuilder(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh)
      : network_(network),
        seed_(seed),
        random_(seed, kLandscapeStream),
        mesh_(mesh),
        low_(network.Min() - kRim),
        high_(network.Max() + kRim) {}

  void Build() {
    const Canal& canal = network_.canal();
    BuildGround(low_.y, canal.centre_y - canal.half_width);
    BuildGround(canal.centre_y + canal.half_width, high_.y);
    BuildCanal();
    for (const Street& street : network_.streets()) {
      if (street.has_bridge) BuildBridge(street);
    }
    BuildFootbridges();
    for (const Junction& junction : network_.junctions()) {
      if (junction.IsBend()) BuildBendSurroundings(junction);
    }
    for (int row = 0; row + 1 < network_.config().rows; ++row) {
      for (int column = 0; column + 1 < network_.config().columns; ++column) BuildBlock(column, row);
    }
    BuildOutskirts();
    BuildHills();
  }

 private:
  void Flat(double x0, double y0, double x1, double y1, double z, const Surface& surface) {
    mesh_->Quad(Lift({x0, y0}, z), Lift({x1, y0}, z), Lift({x1, y1}, z), Lift({x0, y1}, z), surface);
  }

  void BuildGround(double from_y, double to_y) {
    for (double y = from_y; y < to_y - 0.01; y += kTile) {
      for (double x = low_.x; x < high_.x; x += kTile) {
        const bool grass = random_.Chance(0.7);
        Flat(x, y, x + kTile, std::min(y + kTile, to_y), kGroundLevel,
             grass ? MakeSurface(Texture::kGrass, ClassId::kTerrain)
                   : MakeSurface(Texture::kSoil, ClassId::kTerrain));
      }
    }
  }

  void BuildCanal() {
    const Canal& canal = network_.canal();
    Surface water = MakeSurface(Texture::kWater, ClassId::kWater);
    water.metres = 7;
    for (double x = low_.x; x < high_.x; x += kTile) {
      Flat(x, canal.centre_y - canal.half_width, x + kTile, canal.centre_y + canal.half_width, kWaterLevel,
           water);
    }
    for (const int side : {-1, 1}) BuildQuay(canal, side);
  }

  // The canal's wall, its coping and the railing, which leaves out the streets.
  void BuildQuay(const Canal& canal, int side) {
    const Surface wall = MakeSurface(Texture::kRubble, ClassId::kWall, {226, 220, 210});
    const Surface coping = MakeSurface(Texture::kAshlar1, ClassId::kSideWalk);
    const double y = canal.centre_y + side * canal.half_width;
    for (double x = low_.x; x < high_.x; x += 6.0) {
      glm::dvec2 p(x, y);
      glm::dvec2 q(x + 6.0, y);
      if (side < 0) std::swap(p, q);
      const WallFrame frame(p, q);
      frame.Rect(mesh_, 0, static_cast<float>(kWaterLevel - 0.3), frame.width(), 0.02F, 0, wall);
      if (ClearanceFromStreets(network_, {x + 3.0, y}) > 3.2) {
        mesh_->Quad(frame.At(0, 0.02F), frame.At(frame.width(), 0.02F), frame.At(frame.width(), 0.02F, -2.2F),
                    frame.At(0, 0.02F, -2.2F), coping);
        BuildFence(frame, Texture::kRailing, 1.05F, &random_, mesh_);
      }
    }
  }

  // Steel trusses on both sides of the street, with portals at the ends.
  void BuildBridge(const Street& street) {
    const double line = street.HalfRoad() + kSidewalkWidth;
    const double from = street.bridge_from - 0.5;
    const double to = street.bridge_to + 0.5;
    const Surface steel = MakeSurface(Texture::kTruss, ClassId::kBridge);
    for (const int side : {-1, 1}) BuildTruss(street, from, to, side * (line - 0.2), steel);
    for (const double s : {from + 0.2, to - 0.2}) {
      const glm::vec2 across(street.centre.LeftAt(s));
      const glm::vec3 beam(static_cast<float>(2 * line), 0.5F, 0.7F);
      mesh_->Box(Lift(street.centre.PointAt(s), 5.6), across, beam,
                 MakeSurface(Texture::kMetal, ClassId::kBridge, {120, 150, 146}), true);
      mesh_->Box(Lift(street.centre.PointAt(s), 4.9), across, {beam.x, 0.25F, 0.25F},
                 MakeSurface(Texture::kMetal, ClassId::kBridge, {120, 150, 146}), true);
    }
  }

  void BuildTruss(const Street& street, double from, double to, double lateral, const Surface& steel) {
    const Surface solid = MakeSurface(Texture::kMetal, ClassId::kBridge, {120, 150, 146});
    const Surface stone = MakeSurface(Texture::kAshlar0, ClassId::kBridge);
    const int panels = 4;
    const double step = (to - from) / panels;
    for (int i = 0; i < panels; ++i) {
      const double s = from + i * step;
      const glm::vec3 a = Lift(street.centre.OffsetPoint(s, lateral), kKerbHeight);
      const glm::vec3 b = Lift(street.centre.OffsetPoint(s + step, lateral), kKerbHeight);
      const glm::vec3 up(0, 0, 4.6F);
      const glm::vec3 normal(glm::vec2(street.centre.LeftAt(s)) * (lateral > 0 ? -1.0F : 1.0F), 0);
      mesh_->CutQuad({a, b, b + up, a + up}, {0, 0}, {1, 1}, normal, steel);
      const glm::vec2 along(b.x - a.x, b.y - a.y);
      mesh_->Box((a + b) * 0.5F + glm::vec3(0, 0, 4.5F), along, {static_cast<float>(step), 0.35F, 0.4F},
                 solid, true);
      mesh_->Box((a + b) * 0.5F - glm::vec3(0, 0, 1.0F), along, {static_cast<float>(step), 0.3F, 1.35F},
                 stone, true);
    }
    for (const double s : {from, to}) {
      mesh_->Box(Lift(street.centre.OffsetPoint(s, lateral), 0), {1, 0}, {0.6F, 0.6F, 6.3F}, solid);
    }
  }

  // Two streets are crossed by footbridges.
  void BuildFootbridges() {
    for (const auto& [column, row] : {std::pair{0, 0}, std::pair{1, 2}}) {
      const Junction& junction = network_.junctions()[static_cast<size_t>(network_.JunctionAt(column, row))];
      const int street = junction.street[static_cast<size_t>(Side::kEast)];
      if (street >= 0) BuildFootbridge(network_.streets()[static_cast<size_t>(street)]);
    }
  }

  void BuildFootbridge(const Street& street) {
    const double s = street.centre.length() * 0.5;
    const double half = street.HalfRoad() + kSidewalkWidth - 0.8;
    const glm::vec2 across(street.centre.LeftAt(s));
    const Surface concrete = MakeSurface(Texture::kConcrete1, ClassId::kBridge);
    const glm::vec3 middle = Lift(street.centre.PointAt(s), 5.2);
    mesh_->Box(middle, across, {static_cast<float>(2 * half), 2.8F, 0.7F}, concrete, true);
    const glm::vec2 along(street.centre.TangentAt(s));
    const Surface railing = MakeSurface(Texture::kRailing, ClassId::kBridge, {150, 190, 170});
    for (const float side : {-1.4F, 1.4F}) {
      const glm::vec3 base = middle + glm::vec3(along * side, 0.7F);
      const glm::vec3 reach(across * static_cast<float>(half), 0);
      const glm::vec3 up(0, 0, 1.15F);
      mesh_->CutQuad({base - reach, base + reach, base + reach + up, base - reach + up}, {0, 0}, {14, 1},
                     glm::vec3(along * side, 0), railing);
    }
    for (const int side : {-1, 1}) {
      mesh_->Box(Lift(street.centre.OffsetPoint(s, side * (half - 0.4)), 0), across, {0.8F, 2.2F, 5.2F},
                 MakeSurface(Texture::kConcrete0, ClassId::kBridge));
    }
  }

  void BuildBendSurroundings(const Junction& junction) {
    const std::vector<int> arms = ArmsOf(junction);
    const bool in_order = (arms[0] + 1) % kSides == arms[1];
    const int a = in_order ? arms[0] : arms[1];
    const int b = in_order ? arms[1] : arms[0];
    const auto rail = EdgeCurve(network_, junction, b, a, 0.45);
    Surface steel = MakeSurface(Texture::kGuardRail, ClassId::kGuardRail);
    for (size_t i = 0; i + 1 < rail.size(); ++i) {
      const glm::vec3 p = Lift(rail[i], kKerbHeight);
      const glm::vec3 q = Lift(rail[i + 1], kKerbHeight);
      const glm::vec3 up(0, 0, 0.85F);
      const glm::vec3 normal = glm::normalize(glm::vec3(q.y - p.y, p.x - q.x, 0));
      mesh_->CutQuad({p, q, q + up, p + up}, {0, 0}, {glm::distance(p, q) / 2.4F, 1}, normal, steel);
    }
    const Path outside(EdgeCurve(network_, junction, b, a, kSidewalkWidth + 2.5));
    for (double s = 2; s < outside.length(); s += 5.5) {
      BuildTree(Lift(outside.OffsetPoint(s, -random_.Uniform(0, 7)), kGroundLevel), random_.Float(6, 11),
                &random_, mesh_);
    }
  }

  void BuildBlock(int column, int row) {
    const BlockKind kind = BlockAt(network_, seed_, column, row);
    const auto& junctions = network_.junctions();
    const glm::dvec2 a = junctions[static_cast<size_t>(network_.JunctionAt(column, row))].centre;
    const glm::dvec2 b = junctions[static_cast<size_t>(network_.JunctionAt(column + 1, row + 1))].centre;
    const glm::dvec2 middle = (a + b) * 0.5;
    if (kind == BlockKind::kPark) {
      BuildPark(middle, (b - a) * 0.5 - 26.0);
    } else if (kind == BlockKind::kPlaza) {
      BuildPlaza(middle, (b - a) * 0.5 - 17.0);
    } else if (row != 1) {
      BuildBackyard(middle, (b - a) * 0.5 - 30.0);
    }
  }

  glm::dvec2 Somewhere(const glm::dvec2& middle, const glm::dvec2& half) {
    return middle + glm::dvec2(random_.Uniform(-half.x, half.x), random_.Uniform(-half.y, half.y));
  }

  void BuildBackyard(const glm::dvec2& middle, const glm::dvec2& half) {
    Flat(middle.x - half.x, middle.y - half.y, middle.x + half.x, middle.y + half.y, -0.05,
         MakeSurface(Texture::kGravel, ClassId::kGround));
    for (int i = 0; i < 5; ++i) {
      BuildTree(Lift(Somewhere(middle, half), kGroundLevel), random_.Float(6, 11), &random_, mesh_);
    }
  }

  void Ellipse(const glm::dvec2& middle, const glm::dvec2& radii, double z, const Surface& surface) {
    constexpr int kCorners = 24;
    const auto rim = [&](int i) {
      const double angle = glm::two_pi<double>() * i / kCorners;
      return Lift(middle + radii * glm::dvec2(std::cos(angle), std::sin(angle)), z);
    };
    for (int i = 0; i < kCorners; ++i) mesh_->Triangle(Lift(middle, z), rim(i), rim(i + 1), surface);
  }

  void BuildPark(const glm::dvec2& middle, const glm::dvec2& half) {
    const glm::dvec2 pond = middle + glm::dvec2(0, -half.y * 0.55);
    Ellipse(pond, {11.5, 8.5}, -0.06, MakeSurface(Texture::kGravel, ClassId::kGround));
    Ellipse(pond, {9.5, 6.5}, 0.0, MakeSurface(Texture::kWater, ClassId::kWater));
    for (int i = 0; i < 36; ++i) {
      const double angle = glm::two_pi<double>() * i / 36;
      mesh_->Sphere(Lift(pond + glm::dvec2(9.6 * std::cos(angle), 6.6 * std::sin(angle)), 0),
                    glm::vec3(random_.Float(0.3, 0.55)), 6, MakeSurface(Texture::kAshlar1, ClassId::kStatic));
    }
    for (int i = 0; i < 34; ++i) {
      const glm::dvec2 at = Somewhere(middle, half + 6.0);
      if (glm::distance(at, pond) < 12 || ClearanceFromStreets(network_, at) < 2) continue;
      BuildTree(Lift(at, kGroundLevel), random_.Float(6, 12), &random_, mesh_);
    }
    BuildStatue(Lift(middle + glm::dvec2(0, half.y * 0.5), kGroundLevel), &random_, mesh_);
  }

  void BuildPlaza(const glm::dvec2& middle, const glm::dvec2& half) {
    Flat(middle.x - half.x, middle.y - half.y, middle.x + half.x, middle.y + half.y, 0.1,
         MakeSurface(Texture::kPavingSlabs0, ClassId::kGround, {240, 226, 206}));
    BuildFountain(Lift(middle, 0.1), &random_, mesh_);
    BuildStatue(Lift(middle + glm::dvec2(half.x * 0.6, half.y * 0.6), 0.1), &random_, mesh_);
    for (int i = 0; i < 14; ++i) {
      const glm::dvec2 at = Somewhere(middle, half);
      if (glm::distance(at, middle) < 8) continue;
      if (i % 2 == 0) {
        BuildParasol(Lift(at, 0.1), &random_, mesh_);
      } else {
        BuildTree(Lift(at, 0.1), random_.Float(4.5, 7), &random_, mesh_);
      }
    }
  }

  // Trees and sheds outside of the outer streets.
  void BuildOutskirts() {
    for (int i = 0; i < 220; ++i) {
      const glm::dvec2 at(random_.Uniform(low_.x + 60, high_.x - 60),
                          random_.Uniform(low_.y + 60, high_.y - 60));
      const glm::dvec2 inner_low = network_.Min() - 26.0;
      const glm::dvec2 inner_high = network_.Max() + 26.0;
      const bool inside =
          at.x > inner_low.x && at.x < inner_high.x && at.y > inner_low.y && at.y < inner_high.y;
      if (inside || std::abs(at.y - network_.canal().centre_y) < 10) continue;
      BuildTree(Lift(at, kGroundLevel), random_.Float(6, 13), &random_, mesh_);
    }
  }

  void BuildHills() {
    const glm::dvec2 middle = (low_ + high_) * 0.5;
    const double radius = glm::length(high_ - middle) + 20;
    constexpr int kSegments = 72;
    std::vector<double> heights;
    for (int i = 0; i < kSegments; ++i) {
      heights.push_back(26 + 14 * std::sin(i * 0.7) + 9 * std::sin(i * 1.9 + 1) + random_.Uniform(-4, 4));
    }
    Surface hill = MakeSurface(Texture::kHedge, ClassId::kTerrain, {190, 200, 190});
    hill.metres = 60;
    const auto at = [&](int i, double out) {
      const double angle = glm::two_pi<double>() * i / kSegments;
      return middle + (radius + out) * glm::dvec2(std::cos(angle), std::sin(angle));
    };
    for (int i = 0; i < kSegments; ++i) {
      const int next = (i + 1) % kSegments;
      mesh_->Quad(Lift(at(next, -60), kGroundLevel - 1), Lift(at(i, -60), kGroundLevel - 1),
                  Lift(at(i, 80), heights[static_cast<size_t>(i)]),
                  Lift(at(next, 80), heights[static_cast<size_t>(next)]), hill);
    }
  }

  const RoadNetwork& network_;
  uint64_t seed_;
  Random random_;
  MeshBuilder* mesh_;
  glm::dvec2 low_;
  glm::dvec2 high_;
};

}  // namespace

void BuildLandscape(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh) {
  LandscapeBuilder(network, seed, mesh).Build();
}

void BuildSkyDome(MeshBuilder* mesh) {
  constexpr int kSlices = 24;
  constexpr int kStacks = 8;
  Surface sky = MakeSurface(Texture::kSky, ClassId::kSky);
  sky.grime = 0;
  const auto point = [](int stack, int slice) {
    const float elevation = -0.15F + (glm::half_pi<float>() + 0.15F) * static_cast<float>(stack) / kStacks;
    const float azimuth = glm::two_pi<float>() * static_cast<float>(slice) / kSlices;
    return glm::vec3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                     std::sin(elevation));
  };
  for (int stack = 0; stack < kStacks; ++stack) {
    for (int slice = 0; slice < kSlices; ++slice) {
      const float u0 = 2.0F * static_cast<float>(slice) / kSlices;
      const float u1 = 2.0F * static_cast<float>(slice + 1) / kSlices;
      const float v0 = static_cast<float>(stack) / kStacks * 0.98F + 0.01F;
      const float v1 = static_cast<float>(stack + 1) / kStacks * 0.98F + 0.01F;
      mesh->QuadFree({point(stack, slice + 1), point(stack, slice), point(stack + 1, slice),
                      point(stack + 1, slice + 1)},
                     {glm::vec2(u1, v0), glm::vec2(u0, v0), glm::vec2(u0, v1), glm::vec2(u1, v1)}, sky);
    }
  }
}

}  // namespace semmap::town
