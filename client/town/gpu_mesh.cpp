#include "client/town/gpu_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace semmap::town {
namespace {

struct Attribute {
  GLuint location;
  GLint size;
  GLenum type;
  bool normalized;
  bool integer;
  size_t offset;
};

constexpr std::array<Attribute, 6> kAttributes = {{
    {0, 3, GL_FLOAT, false, false, offsetof(Vertex, position)},
    {1, 2, GL_FLOAT, false, false, offsetof(Vertex, uv)},
    {2, 2, GL_FLOAT, false, false, offsetof(Vertex, grime_uv)},
    {3, 4, GL_BYTE, true, false, offsetof(Vertex, normal)},
    {4, 4, GL_UNSIGNED_BYTE, true, false, offsetof(Vertex, tint)},
    {5, 4, GL_UNSIGNED_BYTE, false, true, offsetof(Vertex, layer)},
}};

// Six planes of the view, pointing inwards (Gribb and Hartmann 2001).
std::array<glm::vec4, 6> PlanesOf(const glm::mat4& clip) {
  const auto row = [&clip](int i) { return glm::vec4(clip[0][i], clip[1][i], clip[2][i], clip[3][i]); };
  return {row(3) + row(0), row(3) - row(0), row(3) + row(1),
          row(3) - row(1), row(3) + row(2), row(3) - row(2)};
}

// Small surfaces are left out from where they cover less than about a third of a pixel's width.
struct Tier {
  float largest;  // area of a quad, square metres
  float range;    // metres
};
constexpr std::array<Tier, 3> kTiers = {{{1e9F, 1e9F}, {0.8F, 150.0F}, {0.1F, 60.0F}}};

// The tier of the quad whose six indices start at `first`.
int TierOf(const Mesh& mesh, size_t first) {
  const auto at = [&](size_t k) { return mesh.vertices[mesh.indices[first + k]].position; };
  const float area = (glm::length(glm::cross(at(1) - at(0), at(2) - at(0))) +
                      glm::length(glm::cross(at(4) - at(3), at(5) - at(3)))) /
                     2;
  int tier = 0;
  for (size_t i = 1; i < kTiers.size(); ++i) {
    if (area < kTiers[i].largest) tier = static_cast<int>(i);
  }
  return tier;
}

bool MaySee(const std::array<glm::vec4, 6>& planes, const glm::vec3& low, const glm::vec3& high) {
  return std::all_of(planes.begin(), planes.end(), [&](const glm::vec4& plane) {
    const glm::vec3 normal(plane);
    const glm::vec3 corner(normal.x > 0 ? high.x : low.x, normal.y > 0 ? high.y : low.y,
                           normal.z > 0 ? high.z : low.z);
    return glm::dot(normal, corner) + plane.w > 0;
  });
}

}  // namespace

GpuMesh::GpuMesh(const Mesh& mesh, float cell, const Choice& wanted) {
  using Key = std::array<int, 3>;  // tier, column, row
  std::map<Key, std::vector<uint32_t>> groups;
  for (size_t i = 0; i < mesh.indices.size(); i += 6) {
    const Vertex& first = mesh.vertices[mesh.indices[i]];
    if (wanted != nullptr && !wanted(first)) continue;
    const auto index = [cell](float x) { return cell > 0 ? static_cast<int>(std::floor(x / cell)) : 0; };
    const int tier = cell > 0 ? TierOf(mesh, i) : 0;
    auto& group = groups[{tier, index(first.position.x), index(first.position.y)}];
    group.insert(group.end(), mesh.indices.begin() + static_cast<ptrdiff_t>(i),
                 mesh.indices.begin() + static_cast<ptrdiff_t>(i) + 6);
  }
  std::vector<uint32_t> indices;
  for (const auto& [key, group] : groups) {
    Chunk chunk{glm::vec3(1e9F), glm::vec3(-1e9F), static_cast<GLsizei>(group.size()), indices.size(),
                kTiers[static_cast<size_t>(key[0])].range};
    for (const uint32_t index : group) {
      chunk.low = glm::min(chunk.low, mesh.vertices[index].position);
      chunk.high = glm::max(chunk.high, mesh.vertices[index].position);
    }
    indices.insert(indices.end(), group.begin(), group.end());
    chunks_.push_back(chunk);
  }
  if (!indices.empty()) Upload(mesh, indices);
}

void GpuMesh::Upload(const Mesh& mesh, const std::vector<uint32_t>& indices) {
  vertices_ =
      MakeBuffer(static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(Vertex)), mesh.vertices.data());
  indices_ = MakeBuffer(static_cast<GLsizeiptr>(indices.size() * sizeof(uint32_t)), indices.data());
  array_ = MakeVertexArray();
  glVertexArrayVertexBuffer(array_.get(), 0, vertices_.get(), 0, sizeof(Vertex));
  glVertexArrayElementBuffer(array_.get(), indices_.get());
  for (const Attribute& attribute : kAttributes) {
    const auto offset = static_cast<GLuint>(attribute.offset);
    glEnableVertexArrayAttrib(array_.get(), attribute.location);
    glVertexArrayAttribBinding(array_.get(), attribute.location, 0);
    if (attribute.integer) {
      glVertexArrayAttribIFormat(array_.get(), attribute.location, attribute.size, attribute.type, offset);
    } else {
      glVertexArrayAttribFormat(array_.get(), attribute.location, attribute.size, attribute.type,
                                attribute.normalized ? GL_TRUE : GL_FALSE, offset);
    }
  }
}

void GpuMesh::DrawAll() const {
  if (empty()) return;
  glBindVertexArray(array_.get());
  const Chunk& last = chunks_.back();
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(last.first) + last.count, GL_UNSIGNED_INT, nullptr);
}

void GpuMesh::DrawVisible(const glm::mat4& clip_from_model, const glm::vec3& eye,
                          const Filter& wanted) const {
  if (empty()) return;
  const auto planes = PlanesOf(clip_from_model);
  std::vector<std::pair<float, const Chunk*>> visible;
  for (const Chunk& chunk : chunks_) {
    if (!MaySee(planes, chunk.low, chunk.high)) continue;
    if (wanted != nullptr && !wanted(chunk.low, chunk.high)) continue;
    const float distance = glm::distance(glm::clamp(eye, chunk.low, chunk.high), eye);
    if (distance < chunk.range) visible.emplace_back(distance, &chunk);
  }
  std::stable_sort(visible.begin(), visible.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  glBindVertexArray(array_.get());
  for (const auto& [distance, chunk] : visible) {
    glDrawElements(GL_TRIANGLES, chunk->count, GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(chunk->first * sizeof(uint32_t)));
  }
}

}  // namespace semmap::town
