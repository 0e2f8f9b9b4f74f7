#include "client/town/vegetation.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

namespace semmap::town {
namespace {

glm::vec3 RandomDirection(Random* random) {
  const float z = random->Float(-1, 1);
  const float angle = random->Float(0, glm::two_pi<double>());
  const float r = std::sqrt(std::max(0.0F, 1 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// A square spray of leaves, facing somewhere, lit as part of the round crown.
void AddSpray(const glm::vec3& at, float size, const glm::vec3& normal, const Surface& leaves, Random* random,
              MeshBuilder* mesh) {
  const glm::vec3 facing = glm::normalize(normal + RandomDirection(random) * 0.8F);
  const glm::vec3 helper = std::abs(facing.z) < 0.9F ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
  const glm::vec3 across = glm::normalize(glm::cross(helper, facing));
  const glm::vec3 up = glm::cross(facing, across);
  const float turn = random->Float(0, glm::two_pi<double>());
  const glm::vec3 x = (across * std::cos(turn) + up * std::sin(turn)) * (size / 2);
  const glm::vec3 y = (up * std::cos(turn) - across * std::sin(turn)) * (size / 2);
  mesh->CutQuad({at - x - y, at + x - y, at + x + y, at - x + y}, {0, 0}, {1, 1}, normal, leaves);
}

// Sprays on and in an ellipsoid, the inner ones darker.
void AddCrown(const glm::vec3& centre, const glm::vec3& radii, int sprays, float size, Texture texture,
              Random* random, MeshBuilder* mesh) {
  const double hue = random->Uniform(0.8, 1.0);
  for (int i = 0; i < sprays; ++i) {
    const glm::vec3 direction = RandomDirection(random);
    const float depth = random->Float(0.55, 1.0);
    const double shade = hue * (0.35 + 0.65 * depth) * (0.8 + 0.2 * direction.z) * random->Uniform(0.85, 1.0);
    Surface leaves = MakeSurface(texture, ClassId::kVegetation, Shade({255, 255, 240}, shade));
    leaves.grime = 0.3F;
    const glm::vec3 normal = glm::normalize(direction + glm::vec3(0, 0, 0.35F));
    AddSpray(centre + radii * direction * depth, size * random->Float(0.75, 1.25), normal, leaves, random,
             mesh);
  }
}

}  // namespace

void BuildTree(const glm::vec3& foot, float height, Random* random, MeshBuilder* mesh) {
  const Surface bark =
      MakeSurface(Texture::kBark, ClassId::kVegetation, Shade({255, 250, 245}, random->Uniform(0.7, 1)));
  const float girth = height * random->Float(0.018, 0.026);
  const float fork = height * random->Float(0.32, 0.42);
  const glm::vec3 lean(random->Float(-0.3, 0.3), random->Float(-0.3, 0.3), 0);
  const glm::vec3 top = foot + glm::vec3(0, 0, fork) + lean;
  mesh->Tube(foot - glm::vec3(0, 0, 0.1F), top, girth * 1.25F, girth, 7, bark);
  const float width = height * random->Float(0.26, 0.36);
  const glm::vec3 middle = foot + lean + glm::vec3(0, 0, height * 0.66F);
  for (int i = 0; i < 4; ++i) {
    const glm::vec3 tip = middle + RandomDirection(random) * (width * 0.7F);
    mesh->Tube(top, tip, girth * 0.6F, girth * 0.2F, 4, bark);
  }
  const auto texture = static_cast<Texture>(static_cast<int>(Texture::kLeaves0) + random->Below(3));
  const glm::vec3 radii(width, width, height * 0.33F);
  AddCrown(middle, radii, 60, height * 0.2F, texture, random, mesh);
}

void BuildBush(const glm::vec3& foot, float height, Random* random, MeshBuilder* mesh) {
  const glm::vec3 radii(height * 0.6F, height * 0.6F, height * 0.5F);
  AddCrown(foot + glm::vec3(0, 0, height * 0.5F), radii, 14, height * 0.75F, Texture::kBush, random, mesh);
}

void BuildHedge(const WallFrame& frame, float height, MeshBuilder* mesh) {
  const Surface leaves = MakeSurface(Texture::kHedge, ClassId::kVegetation);
  const float w = frame.width();
  frame.Rect(mesh, 0, 0, w, height, 0, leaves);
  mesh->Quad(frame.At(0, height, 0), frame.At(w, height, 0), frame.At(w, height, -0.7F),
             frame.At(0, height, -0.7F), leaves);
  mesh->Quad(frame.At(w, 0, -0.7F), frame.At(0, 0, -0.7F), frame.At(0, height, -0.7F),
             frame.At(w, height, -0.7F), leaves);
  mesh->Quad(frame.At(0, 0, -0.7F), frame.At(0, 0, 0), frame.At(0, height, 0), frame.At(0, height, -0.7F),
             leaves);
  mesh->Quad(frame.At(w, 0, 0), frame.At(w, 0, -0.7F), frame.At(w, height, -0.7F), frame.At(w, height, 0),
             leaves);
}

void BuildFence(const WallFrame& frame, Texture texture, float height, Random* random, MeshBuilder* mesh) {
  static constexpr std::array<std::array<uint8_t, 3>, 4> kTints = {
      {{255, 255, 255}, {190, 160, 130}, {150, 170, 150}, {210, 200, 190}}};
  const Surface fence = MakeSurface(texture, ClassId::kFence, kTints[static_cast<size_t>(random->Below(4))]);
  const glm::vec3 low0 = frame.At(0, 0.12F, -0.1F);
  const glm::vec3 low1 = frame.At(frame.width(), 0.12F, -0.1F);
  const glm::vec3 up(0, 0, height);
  mesh->CutQuad({low0, low1, low1 + up, low0 + up}, {0, 0}, {frame.width() / (height * 1.3F), 1}, frame.out(),
                fence);
  const Surface foot = MakeSurface(Texture::kConcrete0, ClassId::kFence);
  frame.Ledge(mesh, 0, 0, frame.width(), 0.13F, 0.02F, foot);
  for (float x = 0.1F; x < frame.width(); x += 2.6F) {
    mesh->Box(frame.At(x, 0, -0.12F), frame.along(), {0.1F, 0.1F, height + 0.2F},
              MakeSurface(Texture::kMetal, ClassId::kFence, {150, 150, 146}));
  }
}

}  // namespace semmap::town
