#include "client/town/sun_states.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <opencv2/core/utility.hpp>

namespace semmap::town {
namespace {

// The renderer lifts surfaces by as much before it looks at the map.
constexpr float kLift = 0.06F;

class SunLookup {
 public:
  explicit SunLookup(const ShadowMap& map) : map_(map) {
    const glm::vec3 row(map.texture_from_town[0][0], map.texture_from_town[1][0],
                        map.texture_from_town[2][0]);
    texel_metres_ = 1.0F / (glm::length(row) * static_cast<float>(map.size));
  }

  float texel_metres() const { return texel_metres_; }

  // How many of the four texels around a point are lit.
  int LitTexels(const glm::vec3& point) const {
    const glm::vec3 at(map_.texture_from_town * glm::vec4(point, 1));
    const int x = static_cast<int>(std::floor(at.x * static_cast<float>(map_.size) - 0.5F));
    const int y = static_cast<int>(std::floor(at.y * static_cast<float>(map_.size) - 0.5F));
    int lit = 0;
    for (const int dy : {0, 1}) {
      for (const int dx : {0, 1}) lit += Lit(x + dx, y + dy, at.z) ? 1 : 0;
    }
    return lit;
  }

 private:
  bool Lit(int x, int y, float depth) const {
    if (x < 0 || y < 0 || x >= map_.size || y >= map_.size) return true;
    const size_t index = static_cast<size_t>(y) * static_cast<size_t>(map_.size) + static_cast<size_t>(x);
    return depth * 65535.0F <= static_cast<float>(map_.depth[index]) + 0.5F;
  }

  const ShadowMap& map_;
  float texel_metres_ = 0;
};

SunState StateOf(const SunLookup& lookup, const Vertex* quad, const glm::vec3& normal) {
  const glm::vec3 lift = normal * kLift;
  const glm::vec3 a = quad[0].position + lift;
  const glm::vec3 b = quad[1].position + lift;
  const glm::vec3 c = quad[2].position + lift;
  const glm::vec3 d = quad[3].position + lift;
  const float texel = lookup.texel_metres();
  const auto steps = [texel](float length) {
    return std::max(1, static_cast<int>(std::ceil(length / texel)));
  };
  const int across = steps(std::max(glm::distance(a, b), glm::distance(d, c)));
  const int along = steps(std::max(glm::distance(a, d), glm::distance(b, c)));
  bool any_lit = false;
  bool any_dark = false;
  for (int i = 0; i <= along; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(along);
    const glm::vec3 left = a + (d - a) * t;
    const glm::vec3 right = b + (c - b) * t;
    for (int k = 0; k <= across; ++k) {
      const float u = static_cast<float>(k) / static_cast<float>(across);
      const int lit = lookup.LitTexels(left + (right - left) * u);
      any_lit |= lit > 0;
      any_dark |= lit < 4;
      if (any_lit && any_dark) return SunState::kMixed;
    }
  }
  return any_lit ? SunState::kLit : SunState::kDark;
}

SunState StateOfLeaf(const SunLookup& lookup, const Vertex* quad, const glm::vec3& normal) {
  const glm::vec3 middle = (quad[0].position + quad[2].position) * 0.5F;
  return lookup.LitTexels(middle + normal * 0.25F) >= 2 ? SunState::kLit : SunState::kDark;
}

}  // namespace

void ClassifySun(const ShadowMap& map, const glm::vec3& sun, Mesh* mesh) {
  const SunLookup lookup(map);
  const int quads = static_cast<int>(mesh->vertices.size() / 4);
  cv::parallel_for_(cv::Range(0, quads), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      Vertex* quad = mesh->vertices.data() + 4 * static_cast<ptrdiff_t>(i);
      const glm::vec3 normal =
          glm::normalize(glm::vec3(quad[0].normal[0], quad[0].normal[1], quad[0].normal[2]));
      const bool leaf = quad[0].class_id == static_cast<uint8_t>(ClassId::kVegetation) &&
                        glm::distance(quad[0].position, quad[2].position) < 4;
      SunState state = SunState::kDark;
      if (glm::dot(normal, sun) > 0) {
        state = leaf ? StateOfLeaf(lookup, quad, normal) : StateOf(lookup, quad, normal);
      }
      for (int k = 0; k < 4; ++k) quad[k].sun = static_cast<uint8_t>(state);
    }
  });
}

}  // namespace semmap::town
