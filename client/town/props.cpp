#include "client/town/props.h"

#include <array>

#include <glm/geometric.hpp>

#include "client/town/facade_frame.h"
#include "client/town/vegetation.h"

namespace semmap::town {
namespace {

glm::vec2 LeftOf(const glm::vec2& d) { return {-d.y, d.x}; }
glm::vec3 Up(float z) { return {0, 0, z}; }

// A box whose front shows one cell of an atlas.
void FrontedBox(const glm::vec3& foot, const glm::vec2& facing, const glm::vec3& size, const Surface& body,
                const Surface& front, const CellUv& cell, MeshBuilder* mesh) {
  mesh->Box(foot, facing, size, body);
  const glm::vec3 out(glm::normalize(facing) * (size.x / 2 + 0.005F), 0);
  const glm::vec3 left(LeftOf(glm::normalize(facing)) * (size.y / 2), 0);
  const glm::vec3 a = foot + out + left;
  const glm::vec3 b = foot + out - left;
  // Seen from the front, `left` lies at the right hand.
  mesh->QuadUv(b, a, a + Up(size.z), b + Up(size.z), front, cell.low, cell.high);
}

Surface PoleMetal() { return MakeSurface(Texture::kMetal, ClassId::kPole, {120, 128, 126}); }

}  // namespace

void BuildStreetLamp(const glm::vec3& foot, const glm::vec2& facing, MeshBuilder* mesh) {
  const Surface metal = PoleMetal();
  mesh->Tube(foot, foot + Up(1.1F), 0.13F, 0.11F, 7, metal);
  mesh->Tube(foot + Up(1.1F), foot + Up(6.6F), 0.075F, 0.055F, 6, metal);
  const glm::vec3 reach(glm::normalize(facing) * 1.5F, 0.35F);
  mesh->Tube(foot + Up(6.55F), foot + Up(6.55F) + reach, 0.05F, 0.045F, 5, metal);
  Surface glass = MakeSurface(Texture::kPlaster1, ClassId::kPole, {255, 246, 220});
  glass.glow = 255;
  mesh->Box(foot + Up(6.78F) + reach, facing, {0.8F, 0.3F, 0.14F}, metal, true);
  mesh->Box(foot + Up(6.7F) + reach, facing, {0.6F, 0.22F, 0.08F}, glass, true);
}

void BuildBin(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh) {
  const Surface body = MakeSurface(Texture::kMetal, ClassId::kStatic, {90, 120, 96});
  FrontedBox(foot, facing, {0.45F, 0.5F, 0.95F}, body, MakeSurface(Texture::kBins, ClassId::kStatic),
             CellOf(random->Below(16), 4, 4), mesh);
}

void BuildBench(const glm::vec3& foot, const glm::vec2& facing, MeshBuilder* mesh) {
  const Surface wood = MakeSurface(Texture::kWood, ClassId::kStatic);
  const Surface iron = MakeSurface(Texture::kMetal, ClassId::kStatic, {80, 84, 84});
  const glm::vec2 left = LeftOf(glm::normalize(facing));
  const glm::vec3 back(-glm::normalize(facing) * 0.24F, 0);
  mesh->Box(foot + Up(0.42F), left, {1.7F, 0.45F, 0.06F}, wood, true);
  mesh->Box(foot + Up(0.58F) + back, left, {1.7F, 0.05F, 0.34F}, wood, true);
  for (const float x : {-0.7F, 0.7F})
    mesh->Box(foot + glm::vec3(left * x, 0), left, {0.08F, 0.45F, 0.42F}, iron);
}

void BuildHydrant(const glm::vec3& foot, MeshBuilder* mesh) {
  const Surface red = MakeSurface(Texture::kMetal, ClassId::kStatic, {220, 60, 46});
  mesh->Tube(foot, foot + Up(0.62F), 0.12F, 0.1F, 8, red);
  mesh->Sphere(foot + Up(0.65F), glm::vec3(0.13F), 8, red);
  mesh->Tube(foot + glm::vec3(-0.2F, 0, 0.45F), foot + glm::vec3(0.2F, 0, 0.45F), 0.06F, 0.06F, 6, red, true);
}

void BuildBollard(const glm::vec3& foot, MeshBuilder* mesh) {
  mesh->Tube(foot, foot + Up(0.75F), 0.08F, 0.07F, 7,
             MakeSurface(Texture::kMetal, ClassId::kPole, {70, 74, 76}));
  mesh->Tube(foot + Up(0.75F), foot + Up(0.92F), 0.075F, 0.05F, 7,
             MakeSurface(Texture::kPaint, ClassId::kPole, {240, 60, 50}), true);
}

void BuildPlanter(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh) {
  mesh->Box(foot, facing, {0.8F, 1.6F, 0.55F}, MakeSurface(Texture::kRubble, ClassId::kStatic));
  mesh->Box(foot + Up(0.5F), facing, {0.7F, 1.5F, 0.07F}, MakeSurface(Texture::kSoil, ClassId::kStatic));
  for (const float x : {-0.45F, 0.0F, 0.45F}) {
    BuildBush(foot + glm::vec3(LeftOf(glm::normalize(facing)) * x, 0.5F), random->Float(0.4, 0.7), random,
              mesh);
  }
}

void BuildCabinet(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh) {
  const Surface body =
      MakeSurface(Texture::kMetal, ClassId::kOther, Shade({200, 210, 200}, random->Uniform(0.6, 1)));
  FrontedBox(foot, facing, {0.45F, 1.1F, 1.25F}, body, MakeSurface(Texture::kBins, ClassId::kOther),
             CellOf(random->Below(16), 4, 4), mesh);
}

void BuildAdColumn(const glm::vec3& foot, Random* random, MeshBuilder* mesh) {
  const Surface concrete = MakeSurface(Texture::kConcrete0, ClassId::kOther);
  mesh->Tube(foot, foot + Up(0.4F), 0.68F, 0.68F, 12, concrete, true);
  mesh->Tube(foot + Up(2.9F), foot + Up(3.2F), 0.75F, 0.2F, 12, concrete, true);
  constexpr int kFaces = 12;
  for (int i = 0; i < kFaces; ++i) {
    const auto rim = [&](int k) {
      const float angle = 6.2831853F * static_cast<float>(k) / kFaces;
      return foot + glm::vec3(0.62F * std::cos(angle), 0.62F * std::sin(angle), 0.4F);
    };
    const auto texture = i % 4 < 2 ? Texture::kPosters0 : Texture::kPosters1;
    const CellUv cell = CellOf((random->Below(8) / 2) * 2 % 8, 4, 2);
    mesh->QuadUv(rim(i), rim(i + 1), rim(i + 1) + Up(2.5F), rim(i) + Up(2.5F),
                 MakeSurface(texture, ClassId::kOther), cell.low, cell.high);
  }
}

void BuildBillboard(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh) {
  mesh->Tube(foot, foot + Up(2.4F), 0.12F, 0.12F, 6, MakeSurface(Texture::kMetal, ClassId::kOther));
  Surface poster =
      MakeSurface(random->Chance(0.5) ? Texture::kPosters0 : Texture::kPosters1, ClassId::kOther);
  poster.glow = 160;
  const Surface box = MakeSurface(Texture::kMetal, ClassId::kOther);
  FrontedBox(foot + Up(2.3F), facing, {0.3F, 2.0F, 3.0F}, box, poster, CellOf(random->Below(8), 4, 2), mesh);
  FrontedBox(foot + Up(2.3F), -facing, {0.29F, 2.0F, 3.0F}, box, poster, CellOf(random->Below(8), 4, 2),
             mesh);
}

void BuildBusStop(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh) {
  const glm::vec2 front = glm::normalize(facing);
  const glm::vec2 left = LeftOf(front);
  const Surface frame = MakeSurface(Texture::kMetal, ClassId::kStatic, {110, 120, 130});
  const auto at = [&](float x, float out, float z) { return foot + glm::vec3(left * x + front * out, z); };
  mesh->Box(at(0, 0, 2.4F), left, {4.0F, 1.5F, 0.12F}, frame, true);
  for (const float x : {-1.9F, 1.9F}) mesh->Box(at(x, -0.65F, 0), left, {0.1F, 0.1F, 2.4F}, frame);
  const Surface board =
      MakeSurface(random->Chance(0.5) ? Texture::kPosters0 : Texture::kPosters1, ClassId::kStatic);
  FrontedBox(at(-1.9F, 0.0F, 0.3F), left, {0.12F, 1.2F, 1.9F}, frame, board, CellOf(random->Below(8), 4, 2),
             mesh);
  FrontedBox(at(0.2F, -0.68F, 0.4F), front, {0.05F, 3.4F, 1.8F},
             MakeSurface(Texture::kMetal, ClassId::kStatic, {150, 170, 180}),
             MakeSurface(Texture::kWindows4, ClassId::kStatic), CellOf(random->Below(16), 4, 4), mesh);
  BuildBench(at(0.3F, -0.3F, 0), front, mesh);
}

void BuildTrafficSign(const glm::vec3& foot, const glm::vec2& facing, int sign, MeshBuilder* mesh) {
  mesh->Tube(foot, foot + Up(3.0F), 0.045F, 0.045F, 6, PoleMetal());
  const glm::vec2 front = glm::normalize(facing);
  const glm::vec3 middle = foot + glm::vec3(front * 0.06F, 2.65F);
  const glm::vec3 left(LeftOf(front) * 0.36F, 0);
  const CellUv cell = CellOf(sign, 4, 4);
  mesh->CutQuad({middle - left - Up(0.36F), middle + left - Up(0.36F), middle + left + Up(0.36F),
                 middle - left + Up(0.36F)},
                cell.low, cell.high, glm::vec3(front, 0),
                MakeSurface(Texture::kTrafficSigns, ClassId::kTrafficSign));
}

void BuildStatue(const glm::vec3& foot, Random* random, MeshBuilder* mesh) {
  const Surface stone = MakeSurface(Texture::kAshlar0, ClassId::kOther);
  Surface bronze = MakeSurface(Texture::kMetal, ClassId::kOther, {110, 140, 120});
  mesh->Box(foot, {1, 0}, {2.4F, 2.4F, 0.4F}, stone);
  mesh->Box(foot + Up(0.4F), {1, 0}, {1.4F, 1.4F, 1.9F}, stone);
  const glm::vec3 hip = foot + Up(3.1F);
  for (const float x : {-0.16F, 0.16F})
    mesh->Tube(foot + glm::vec3(x, 0, 2.3F), hip + glm::vec3(x, 0, 0), 0.13F, 0.17F, 7, bronze);
  mesh->Tube(hip, hip + Up(0.9F), 0.28F, 0.34F, 8, bronze, true);
  mesh->Sphere(hip + Up(1.2F), glm::vec3(0.2F, 0.2F, 0.25F), 8, bronze);
  const float raise = random->Float(0.2, 1.2);
  mesh->Tube(hip + glm::vec3(0.3F, 0, 0.8F), hip + glm::vec3(0.9F, 0.2F, raise), 0.09F, 0.07F, 6, bronze,
             true);
}

void BuildFountain(const glm::vec3& foot, Random* random, MeshBuilder* mesh) {
  const Surface stone = MakeSurface(Texture::kAshlar0, ClassId::kStatic);
  Surface water = MakeSurface(Texture::kWater, ClassId::kWater);
  constexpr int kBasinSides = 20;
  mesh->Tube(foot, foot + Up(0.65F), 4.6F, 4.4F, kBasinSides, stone);
  mesh->Tube(foot + Up(0.35F), foot + Up(0.64F), 3.9F, 4.0F, kBasinSides, water);
  for (int i = 0; i < kBasinSides; ++i) {
    const auto rim = [&](int k, float radius) {
      const float angle = 6.2831853F * static_cast<float>(k) / kBasinSides;
      return foot + glm::vec3(radius * std::cos(angle), radius * std::sin(angle), 0.65F);
    };
    mesh->Triangle(foot + Up(0.55F), rim(i, 4.0F) - Up(0.1F), rim(i + 1, 4.0F) - Up(0.1F), water);
    mesh->Quad(rim(i, 4.0F), rim(i, 4.4F), rim(i + 1, 4.4F), rim(i + 1, 4.0F), stone);
  }
  mesh->Tube(foot + Up(0.4F), foot + Up(1.9F), 0.4F, 0.25F, 10, stone);
  mesh->Tube(foot + Up(1.9F), foot + Up(2.2F), 0.3F, 1.3F, 12, stone);
  BuildStatue(foot + glm::vec3(random->Float(6.5, 8.0), 0, 0), random, mesh);
}

void BuildParasol(const glm::vec3& foot, Random* random, MeshBuilder* mesh) {
  static constexpr std::array<std::array<uint8_t, 3>, 4> kCloths = {
      {{200, 70, 60}, {230, 220, 190}, {70, 110, 150}, {90, 140, 90}}};
  const Surface cloth =
      MakeSurface(Texture::kPlaster1, ClassId::kOther, kCloths[static_cast<size_t>(random->Below(4))]);
  mesh->Tube(foot, foot + Up(2.5F), 0.04F, 0.04F, 5, MakeSurface(Texture::kWood, ClassId::kOther));
  mesh->Tube(foot + Up(2.0F), foot + Up(2.6F), 1.5F, 0.05F, 8, cloth);
  mesh->Tube(foot + Up(0.7F), foot + Up(0.75F), 0.5F, 0.5F, 10,
             MakeSurface(Texture::kWood, ClassId::kDynamic), true);
  for (int i = 0; i < 3; ++i) {  // chairs
    const float angle = 2.1F * static_cast<float>(i) + random->Float(0, 1);
    const glm::vec2 out(std::cos(angle), std::sin(angle));
    const glm::vec3 at = foot + glm::vec3(out * 0.95F, 0);
    mesh->Box(at, out, {0.4F, 0.4F, 0.45F}, MakeSurface(Texture::kWood, ClassId::kDynamic));
    mesh->Box(at + glm::vec3(out * 0.2F, 0.45F), out, {0.05F, 0.4F, 0.45F},
              MakeSurface(Texture::kWood, ClassId::kDynamic));
  }
}

void BuildLooseThings(const glm::vec3& foot, const glm::vec2& facing, Random* random, MeshBuilder* mesh) {
  const glm::vec2 left = LeftOf(glm::normalize(facing));
  const int kind = random->Below(4);
  if (kind == 0) {  // wheeled bins
    for (int i = 0; i < random->Integer(1, 3); ++i) {
      FrontedBox(foot + glm::vec3(left * (0.75F * static_cast<float>(i)), 0), facing, {0.65F, 0.58F, 1.08F},
                 MakeSurface(Texture::kMetal, ClassId::kDynamic, {70, 90, 80}),
                 MakeSurface(Texture::kBins, ClassId::kDynamic), CellOf(random->Below(16), 4, 4), mesh);
    }
  } else if (kind == 1) {  // boxes
    for (int i = 0; i < 4; ++i) {
      const glm::vec2 turn(random->Float(-1, 1), random->Float(0.2, 1));
      const float size = random->Float(0.3, 0.6);
      mesh->Box(foot + glm::vec3(left * random->Float(-0.8, 0.8), i == 3 ? 0.4F : 0.0F), turn,
                glm::vec3(size), MakeSurface(Texture::kWood, ClassId::kDynamic, {240, 210, 170}));
    }
  } else if (kind == 2) {  // bags
    for (int i = 0; i < 4; ++i) {
      mesh->Sphere(foot + glm::vec3(left * random->Float(-0.7, 0.7), 0.25F), {0.32F, 0.28F, 0.36F}, 7,
                   MakeSurface(Texture::kCloth0, ClassId::kDynamic, {90, 90, 100}));
    }
  } else {  // cones and a barrier
    for (const float x : {-1.0F, 1.0F}) {
      const glm::vec3 at = foot + glm::vec3(left * x, 0);
      mesh->Box(at, facing, {0.4F, 0.4F, 0.05F},
                MakeSurface(Texture::kMetal, ClassId::kDynamic, {50, 50, 50}));
      mesh->Tube(at, at + Up(0.4F), 0.15F, 0.08F, 8,
                 MakeSurface(Texture::kPaint, ClassId::kDynamic, {250, 110, 40}));
      mesh->Tube(at + Up(0.4F), at + Up(0.7F), 0.08F, 0.03F, 8,
                 MakeSurface(Texture::kPaint, ClassId::kDynamic));
    }
    for (int i = 0; i < 6; ++i) {
      mesh->Box(foot + glm::vec3(left * (0.3F * static_cast<float>(i) - 0.75F), 0.75F), left,
                {0.3F, 0.05F, 0.2F},
                MakeSurface(
                    Texture::kPaint, ClassId::kDynamic,
                    i % 2 == 0 ? std::array<uint8_t, 3>{220, 40, 40} : std::array<uint8_t, 3>{250, 250, 250}),
                true);
    }
  }
}

void BuildSignalPost(const glm::vec3& foot, const glm::vec2& arm, float reach, MeshBuilder* mesh) {
  const Surface metal = PoleMetal();
  mesh->Tube(foot, foot + Up(5.9F), 0.11F, 0.08F, 7, metal);
  mesh->Tube(foot + Up(5.7F), foot + glm::vec3(glm::normalize(arm) * reach, 5.9F), 0.07F, 0.05F, 6, metal);
  mesh->Box(foot, arm, {0.35F, 0.35F, 0.5F}, MakeSurface(Texture::kConcrete0, ClassId::kPole));
}

}  // namespace semmap::town
