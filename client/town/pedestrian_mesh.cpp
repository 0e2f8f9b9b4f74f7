#include "client/town/pedestrian_mesh.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "client/town/facade_frame.h"
#include "client/town/random.h"

namespace semmap::town {
namespace {

constexpr float kHip = 0.9F;
constexpr float kKnee = 0.44F;  // length of the thigh
constexpr float kShoulder = 1.42F;
constexpr double kStrideMetres = 1.4;  // of both legs together

// A round limb, its cell of the texture wrapped around it, the seam at the back.
void Wrap(const glm::vec3& from, const glm::vec3& to, const glm::vec2& radius_from,
          const glm::vec2& radius_to, const Surface& surface, const CellUv& cell, MeshBuilder* mesh) {
  constexpr int kLimbSides = 8;
  const auto rim = [&](const glm::vec3& middle, const glm::vec2& radius, int i) {
    const float angle = glm::two_pi<float>() * static_cast<float>(i) / kLimbSides + glm::pi<float>();
    return middle + glm::vec3(radius.x * std::cos(angle), radius.y * std::sin(angle), 0);
  };
  const auto uv = [&](int i, float v) {
    return glm::mix(cell.low, cell.high, glm::vec2(static_cast<float>(i) / kLimbSides, v));
  };
  const bool upward = to.z > from.z;
  const glm::vec3& low = upward ? from : to;
  const glm::vec3& high = upward ? to : from;
  const glm::vec2& low_radius = upward ? radius_from : radius_to;
  const glm::vec2& high_radius = upward ? radius_to : radius_from;
  for (int i = 0; i < kLimbSides; ++i) {
    mesh->QuadFree({rim(low, low_radius, i), rim(low, low_radius, i + 1), rim(high, high_radius, i + 1),
                    rim(high, high_radius, i)},
                   {uv(i, 0), uv(i + 1, 0), uv(i + 1, 1), uv(i, 1)}, surface);
    mesh->QuadFree(
        {high, rim(high, high_radius, i), rim(high, high_radius, i + 1), rim(high, high_radius, i + 1)},
        {uv(i, 1), uv(i, 1), uv(i + 1, 1), uv(i + 1, 1)}, surface);
  }
}

Surface Cloth(Texture texture) {
  Surface cloth = MakeSurface(texture, ClassId::kPedestrian);
  cloth.grime = 0.1F;
  return cloth;
}

void BuildHead(const Surface& face, const CellUv& cell, MeshBuilder* head) {
  const glm::vec2 neck(0.055F, 0.055F);
  Wrap({0, 0, -0.08F}, {0, 0, 0.02F}, neck, neck, face, cell, head);
  const std::array<float, 5> heights = {0.0F, 0.06F, 0.14F, 0.22F, 0.26F};
  const std::array<float, 5> radii = {0.05F, 0.085F, 0.1F, 0.085F, 0.02F};
  for (size_t i = 0; i + 1 < heights.size(); ++i) {
    const CellUv part = {{cell.low.x, glm::mix(cell.low.y, cell.high.y, heights[i] / 0.26F)},
                         {cell.high.x, glm::mix(cell.low.y, cell.high.y, heights[i + 1] / 0.26F)}};
    Wrap({0, 0, heights[i]}, {0, 0, heights[i + 1]}, {radii[i], radii[i] * 0.85F},
         {radii[i + 1], radii[i + 1] * 0.85F}, face, part, head);
  }
}

}  // namespace

std::vector<MeshBuilder> BuildPerson(uint64_t look) {
  Random random(look);
  std::vector<MeshBuilder> limbs(kLimbs);
  const auto limb = [&limbs](Limb which) { return &limbs[static_cast<size_t>(which)]; };
  const Surface shirt = Cloth(random.Chance(0.5) ? Texture::kCloth0 : Texture::kCloth1);
  const Surface trousers = Cloth(random.Chance(0.5) ? Texture::kCloth0 : Texture::kCloth1);
  const Surface shoe = MakeSurface(Texture::kBark, ClassId::kPedestrian, {70, 60, 56});
  const CellUv shirt_cell = CellOf(random.Below(16), 4, 4);
  const CellUv trouser_cell = CellOf(random.Below(16), 4, 4);
  const CellUv face_cell = CellOf(random.Below(16), 4, 4);
  MeshBuilder* body = limb(Limb::kBody);
  Wrap({0, 0, kHip - 0.06F}, {0, 0, 1.1F}, {0.12F, 0.16F}, {0.115F, 0.15F}, trousers, trouser_cell, body);
  Wrap({0, 0, 1.02F}, {0, 0, kShoulder}, {0.125F, 0.165F}, {0.12F, 0.2F}, shirt, shirt_cell, body);
  Wrap({0, 0, kShoulder}, {0, 0, kShoulder + 0.07F}, {0.12F, 0.2F}, {0.06F, 0.07F}, shirt, shirt_cell, body);
  if (random.Chance(0.4)) {
    body->Box({-0.19F, 0, 1.0F}, {1, 0}, {0.16F, 0.3F, 0.4F},
              MakeSurface(Texture::kCloth1, ClassId::kPedestrian, {150, 140, 130}), true);
  }
  BuildHead(Cloth(Texture::kFaces), face_cell, limb(Limb::kHead));
  for (const Limb which : {Limb::kThighLeft, Limb::kThighRight}) {
    Wrap({0, 0, 0.04F}, {0, 0, -kKnee}, {0.085F, 0.085F}, {0.06F, 0.06F}, trousers, trouser_cell,
         limb(which));
  }
  for (const Limb which : {Limb::kShinLeft, Limb::kShinRight}) {
    Wrap({0, 0, 0}, {0, 0, -0.4F}, {0.06F, 0.06F}, {0.045F, 0.045F}, trousers, trouser_cell, limb(which));
    limb(which)->Box({0.06F, 0, -0.46F}, {1, 0}, {0.27F, 0.1F, 0.09F}, shoe, true);
  }
  for (const Limb which : {Limb::kArmLeft, Limb::kArmRight}) {
    Wrap({0, 0, 0.02F}, {0.02F, 0, -0.3F}, {0.055F, 0.05F}, {0.045F, 0.045F}, shirt, shirt_cell, limb(which));
    Wrap({0.02F, 0, -0.3F}, {0.06F, 0, -0.58F}, {0.043F, 0.043F}, {0.035F, 0.035F}, shirt, shirt_cell,
         limb(which));
    Wrap({0.06F, 0, -0.57F}, {0.07F, 0, -0.68F}, {0.035F, 0.04F}, {0.02F, 0.03F}, Cloth(Texture::kFaces),
         face_cell, limb(which));
  }
  return limbs;
}

std::vector<glm::mat4> WalkingPose(double travelled, double stride) {
  std::vector<glm::mat4> pose(kLimbs);
  const double phase = glm::two_pi<double>() * travelled / kStrideMetres;
  const auto swing = static_cast<float>(0.48 * stride * std::sin(phase));
  const glm::vec3 left_axis(0, 1, 0);  // a positive turn swings a hanging limb backwards
  const auto joint = [&](const glm::vec3& at, float angle) {
    return glm::rotate(glm::translate(glm::mat4(1), at), -angle, left_axis);
  };
  const auto bob = static_cast<float>(0.02 * stride * std::cos(2 * phase));
  const glm::mat4 body = glm::translate(glm::mat4(1), glm::vec3(0, 0, bob));
  const auto set = [&](Limb which, const glm::mat4& frame) {
    pose[static_cast<size_t>(which)] = body * frame;
  };
  set(Limb::kBody, glm::mat4(1));
  set(Limb::kHead, glm::translate(glm::mat4(1), glm::vec3(0.01F, 0, kShoulder + 0.1F)));
  const auto knee = [&](double at) {
    return static_cast<float>(0.75 * stride * std::max(0.0, std::cos(at)));
  };
  const auto leg = [&](Limb thigh, Limb shin, float y, float angle, float bend) {
    const glm::mat4 hip = joint({0, y, kHip}, angle);
    set(thigh, hip);
    set(shin, hip * glm::rotate(glm::translate(glm::mat4(1), glm::vec3(0, 0, -kKnee)), bend, left_axis));
  };
  leg(Limb::kThighLeft, Limb::kShinLeft, 0.09F, swing, knee(phase));
  leg(Limb::kThighRight, Limb::kShinRight, -0.09F, -swing, knee(phase + glm::pi<double>()));
  set(Limb::kArmLeft, joint({0, 0.23F, kShoulder - 0.02F}, -swing * 0.8F));
  set(Limb::kArmRight, joint({0, -0.23F, kShoulder - 0.02F}, swing * 0.8F));
  return pose;
}

}  // namespace semmap::town
