#include "client/town/vehicle_mesh.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "client/town/facade_frame.h"
#include "client/town/random.h"
#include "client/town/vehicle_shapes.h"

namespace semmap::town {
namespace {

using Corner = std::pair<glm::vec3, glm::vec2>;  // position, texture

class VehicleBuilder {
 public:
  VehicleBuilder(int kind, uint64_t look, MeshBuilder* mesh)
      : shape_(ShapeOf(kind)), random_(look), mesh_(mesh) {
    static constexpr std::array<std::array<uint8_t, 3>, 9> kPaints = {{{250, 250, 250},
                                                                       {40, 42, 46},
                                                                       {150, 154, 160},
                                                                       {180, 36, 34},
                                                                       {40, 76, 150},
                                                                       {60, 110, 80},
                                                                       {226, 190, 70},
                                                                       {120, 90, 70},
                                                                       {150, 190, 210}}};
    body_ = MakeSurface(shape_.texture, ClassId::kVehicles, kPaints[static_cast<size_t>(random_.Below(9))]);
    body_.grime = 0.25F;
  }

  void Build() {
    BuildFlank(+1);
    BuildFlank(-1);
    BuildBack();
    for (const double axle : {shape_.front_axle, shape_.rear_axle}) {
      for (const int side : {1, -1}) BuildWheel(axle, side);
    }
    const auto half = static_cast<float>(shape_.length * 0.49);
    mesh_->Box({0, 0, 0.2F}, {1, 0}, {2 * half, static_cast<float>(shape_.width * 0.86), 0.1F},
               MakeSurface(Texture::kMetal, ClassId::kVehicles, {20, 20, 22}), true);
  }

 private:
  // Half of the width at a height: the cabin leans in.
  float HalfWidth(double z) const {
    const double lean = std::max(0.0, z - shape_.belt) / (1.0 - shape_.belt);
    const double inset = shape_.texture == Texture::kBus || shape_.texture == Texture::kVan ? 0.05 : 0.2;
    return static_cast<float>(shape_.width / 2 * (1.0 - inset * lean));
  }
  glm::vec3 Place(const glm::dvec2& p, int side) const {
    return {static_cast<float>(p.x * shape_.length), static_cast<float>(side) * HalfWidth(p.y),
            static_cast<float>(p.y * shape_.height)};
  }
  static glm::vec2 FlankUv(const glm::dvec2& p) {
    return {static_cast<float>(p.x + 0.5), static_cast<float>(1.0 - (1.0 - p.y) * 192.0 / 512.0)};
  }

  void Face(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
    mesh_->QuadFree({a.first, b.first, c.first, d.first}, {a.second, b.second, c.second, d.second}, body_);
  }

  // The side, as strips from the sill to the outline.
  void BuildFlank(int side) {
    const auto corner = [&](const glm::dvec2& p) { return Corner{Place(p, side), FlankUv(p)}; };
    const auto& outline = shape_.outline;
    const double sill = outline.front().y;
    for (size_t i = 0; i + 1 < outline.size(); ++i) {
      if (outline[i + 1].x - outline[i].x < 1e-6) continue;
      const auto at_belt = [&](const glm::dvec2& p) { return glm::dvec2(p.x, std::min(p.y, shape_.belt)); };
      const Corner low0 = corner({outline[i].x, sill});
      const Corner low1 = corner({outline[i + 1].x, sill});
      const Corner mid0 = corner(at_belt(outline[i]));
      const Corner mid1 = corner(at_belt(outline[i + 1]));
      const Corner top0 = corner(outline[i]);
      const Corner top1 = corner(outline[i + 1]);
      if (side < 0) {
        Face(low0, low1, mid1, mid0);
        Face(mid0, mid1, top1, top0);
      } else {
        Face(low1, low0, mid0, mid1);
        Face(mid1, mid0, top0, top1);
      }
    }
  }

  // What lies between the flanks: rear, roof, screens, bonnet and front.
  void BuildBack() {
    const auto& outline = shape_.outline;
    for (size_t i = 0; i + 1 < outline.size(); ++i) {
      const glm::dvec2& p = outline[i];
      const glm::dvec2& q = outline[i + 1];
      const bool steep = std::abs(q.y - p.y) * shape_.height > std::abs(q.x - p.x) * shape_.length;
      const auto uv = [&](const glm::dvec2& at, int side) {
        const double across = 0.5 - 0.5 * side;  // 0 on the left
        if (!steep) return glm::vec2(at.x + 0.5, (512.0 - 192.0 - 192.0 * across) / 512.0);
        const double v = at.y * 128.0 / 512.0;
        // Front and rear are painted as one looks at them.
        return at.x > 0 ? glm::vec2(across * -0.5 + 0.5, v) : glm::vec2(0.5 + across * 0.5, v);
      };
      Face({Place(p, 1), uv(p, 1)}, {Place(p, -1), uv(p, -1)}, {Place(q, -1), uv(q, -1)},
           {Place(q, 1), uv(q, 1)});
    }
  }

  void BuildWheel(double axle, int side) {
    constexpr int kSpokes = 12;
    const auto radius = static_cast<float>(shape_.wheel_radius);
    const auto x = static_cast<float>(axle * shape_.length);
    const float outer = static_cast<float>(side) * (HalfWidth(0) + 0.01F);
    const float inner = static_cast<float>(side) * (HalfWidth(0) - 0.22F);
    const CellUv cell = CellOf(wheel_, 4, 4);
    Surface rubber = MakeSurface(Texture::kWheels, ClassId::kVehicles);
    rubber.grime = 0.2F;
    const auto rim = [&](int i, float y) {
      const float angle = glm::two_pi<float>() * static_cast<float>(i) / kSpokes * static_cast<float>(-side);
      return glm::vec3(x + radius * std::cos(angle), y, radius + radius * std::sin(angle));
    };
    const auto uv = [&](int i) {
      const float angle = glm::two_pi<float>() * static_cast<float>(i) / kSpokes;
      return (cell.low + cell.high) * 0.5F +
             (cell.high - cell.low) * 0.5F * glm::vec2(std::cos(angle), std::sin(angle));
    };
    const glm::vec3 hub(x, outer, radius);
    const glm::vec2 middle = (cell.low + cell.high) * 0.5F;
    for (int i = 0; i < kSpokes; ++i) {
      mesh_->QuadFree({hub, rim(i, outer), rim(i + 1, outer), rim(i + 1, outer)},
                      {middle, uv(i), uv(i + 1), uv(i + 1)}, rubber);
      mesh_->QuadFree({rim(i, outer), rim(i, inner), rim(i + 1, inner), rim(i + 1, outer)},
                      {cell.low, cell.low, cell.low, cell.low}, rubber);
    }
  }

  const VehicleShape& shape_;
  Random random_;
  MeshBuilder* mesh_;
  Surface body_;
  int wheel_ = random_.Below(16);
};

}  // namespace

void BuildVehicle(int kind, uint64_t look, MeshBuilder* mesh) { VehicleBuilder(kind, look, mesh).Build(); }

}  // namespace semmap::town
