#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "client/town/classes.h"
#include "client/town/materials.h"

namespace semmap::town {

// What the renderer uploads; 40 bytes.
struct Vertex {
  glm::vec3 position;            // metres
  glm::vec2 uv;                  // in tiles of the texture layer
  glm::vec2 grime_uv;            // metres on the surface, for the large-scale stains
  std::array<int8_t, 4> normal;  // x, y, z of 127; the fourth: kVertexFlag...
  std::array<uint8_t, 4> tint;   // RGB factor; A: how brightly it shines by itself at night
  uint8_t layer;                 // of the texture array
  uint8_t class_id;
  uint8_t grime;  // strength of the stains, 0 to 255
  uint8_t sun;    // SunState; kMixed where nobody has looked
};
static_assert(sizeof(Vertex) == 40);

struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;
};

// How a surface looks and what it is.
struct Surface {
  Texture texture = Texture::kPlaster0;
  ClassId class_id = ClassId::kUnlabeled;
  std::array<uint8_t, 3> tint{255, 255, 255};
  uint8_t glow = 0;    // share of the colour that shines by itself when the town's lights are on
  float metres = 0;    // size of one texture tile; 0: the texture's own
  float grime = 1.0F;  // strength of the stains, 0 to 1
};

Surface MakeSurface(Texture texture, ClassId class_id, std::array<uint8_t, 3> tint = {255, 255, 255});
std::array<uint8_t, 3> Shade(std::array<uint8_t, 3> tint, double factor);

// Collects triangles: solid ones, seen from outside only, and cut-out ones (leaves, fences), seen from both
// sides and with holes where the texture's alpha is low.
class MeshBuilder {
 public:
  // Corners counter-clockwise as seen from outside. Texture runs along a->b and a->d, in metres.
  void Quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d,
            const Surface& surface);
  // The same, with the texture rectangle (u0, v0)-(u1, v1) stretched over it; v runs up from a to d.
  void QuadUv(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d,
              const Surface& surface, const glm::vec2& uv_a, const glm::vec2& uv_c);
  // Four free texture coordinates.
  void QuadFree(const std::array<glm::vec3, 4>& corners, const std::array<glm::vec2, 4>& uv,
                const Surface& surface);
  void Triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const Surface& surface);
  // A cut-out quad; `normal` is what lights it.
  void CutQuad(const std::array<glm::vec3, 4>& corners, const glm::vec2& uv_a, const glm::vec2& uv_c,
               const glm::vec3& normal, const Surface& surface);

  // A box standing on `base` (the centre of its underside), turned about z so that its length lies along
  // `forward`.
  void Box(const glm::vec3& base, const glm::vec2& forward, const glm::vec3& size, const Surface& surface,
           bool with_underside = false);
  // An upright cylinder or cone frustum of `sides` faces between two points.
  void Tube(const glm::vec3& from, const glm::vec3& to, float radius_from, float radius_to, int sides,
            const Surface& surface, bool capped = false);
  void Sphere(const glm::vec3& centre, const glm::vec3& radii, int slices, const Surface& surface);
  // A strip between two polylines of the same count, left to right across, normal up.
  void Ribbon(const std::vector<glm::vec3>& left, const std::vector<glm::vec3>& right,
              const Surface& surface);

  // Everything added from here on has its texture moved by this much, metres, so that neighbours differ.
  void SetTextureShift(const glm::vec2& shift) { shift_ = shift; }

  const Mesh& solid() const { return solid_; }
  const Mesh& cut() const { return cut_; }
  Mesh& mutable_solid() { return solid_; }
  Mesh& mutable_cut() { return cut_; }
  // Adds another builder's triangles moved by `transform` (rotation and translation).
  void AppendMoved(const MeshBuilder& other, const glm::mat4& transform);

 private:
  void Push(Mesh* mesh, const std::array<glm::vec3, 4>& corners, const std::array<glm::vec2, 4>& uv,
            const std::array<glm::vec2, 4>& grime_uv, const glm::vec3& normal, const Surface& surface);
  std::array<glm::vec2, 4> GrimeUv(const std::array<glm::vec3, 4>& corners, const glm::vec3& normal) const;

  Mesh solid_;
  Mesh cut_;
  glm::vec2 shift_{0, 0};
};

}  // namespace semmap::town
