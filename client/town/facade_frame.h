#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "client/town/mesh.h"

namespace semmap::town {

// Coordinates on a wall: x along it from its left end, z up, `out` towards who looks at it; metres.
class WallFrame {
 public:
  WallFrame(const glm::dvec2& p, const glm::dvec2& q)
      : origin_(static_cast<float>(p.x), static_cast<float>(p.y), 0.0F) {
    const glm::vec2 across(static_cast<float>(q.x - p.x), static_cast<float>(q.y - p.y));
    width_ = glm::length(across);
    x_ = glm::vec3(across / width_, 0);
    out_ = glm::vec3(x_.y, -x_.x, 0);
  }

  float width() const { return width_; }
  const glm::vec3& out() const { return out_; }
  glm::vec2 along() const { return {x_.x, x_.y}; }
  glm::vec3 At(float x, float z, float out = 0) const {
    return origin_ + x_ * x + out_ * out + glm::vec3(0, 0, z);
  }

  void Rect(MeshBuilder* mesh, float x0, float z0, float x1, float z1, float out,
            const Surface& surface) const {
    mesh->Quad(At(x0, z0, out), At(x1, z0, out), At(x1, z1, out), At(x0, z1, out), surface);
  }
  void RectUv(MeshBuilder* mesh, float x0, float z0, float x1, float z1, float out, const Surface& surface,
              const glm::vec2& uv0, const glm::vec2& uv1) const {
    mesh->QuadUv(At(x0, z0, out), At(x1, z0, out), At(x1, z1, out), At(x0, z1, out), surface, uv0, uv1);
  }
  // A box that stands out of the wall by `depth`: front, top, underside and both ends.
  void Ledge(MeshBuilder* mesh, float x0, float z0, float x1, float z1, float depth,
             const Surface& surface) const {
    Rect(mesh, x0, z0, x1, z1, depth, surface);
    mesh->Quad(At(x0, z1, depth), At(x1, z1, depth), At(x1, z1, 0), At(x0, z1, 0), surface);
    mesh->Quad(At(x0, z0, 0), At(x1, z0, 0), At(x1, z0, depth), At(x0, z0, depth), surface);
    mesh->Quad(At(x0, z0, 0), At(x0, z0, depth), At(x0, z1, depth), At(x0, z1, 0), surface);
    mesh->Quad(At(x1, z0, depth), At(x1, z0, 0), At(x1, z1, 0), At(x1, z1, depth), surface);
  }

 private:
  glm::vec3 origin_;
  glm::vec3 x_;
  glm::vec3 out_;
  float width_ = 0;
};

// Texture rectangle of cell `index` in a layer of `columns` x `rows` cells, counted from the top left.
struct CellUv {
  glm::vec2 low;
  glm::vec2 high;
};
inline CellUv CellOf(int index, int columns, int rows) {
  const float w = 1.0F / static_cast<float>(columns);
  const float h = 1.0F / static_cast<float>(rows);
  const auto column = static_cast<float>(index % columns);
  const auto row = static_cast<float>(index / columns);
  // Half a texel inside, so that neighbours do not bleed in.
  const float rim = 1.0F / 512.0F;
  return {{column * w + rim, 1.0F - (row + 1) * h + rim}, {(column + 1) * w - rim, 1.0F - row * h - rim}};
}

}  // namespace semmap::town
