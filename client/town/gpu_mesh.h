#pragma once

#include <array>
#include <functional>
#include <vector>

#include <glm/mat4x4.hpp>

#include "client/town/gl_objects.h"
#include "client/town/mesh.h"

namespace semmap::town {

// A mesh on the GPU, its triangles grouped by place so that what the camera cannot see is left out.
class GpuMesh {
 public:
  GpuMesh() = default;
  // Groups of `cell` metres; 0: all in one. Only quads of which `wanted` (given their first vertex) is true.
  using Choice = std::function<bool(const Vertex&)>;
  GpuMesh(const Mesh& mesh, float cell, const Choice& wanted = nullptr);

  bool empty() const { return chunks_.empty(); }
  void DrawAll() const;
  // Draws the groups that may lie in the view and that `wanted` (given the group's box) asks for, near ones
  // first.
  using Filter = std::function<bool(const glm::vec3& low, const glm::vec3& high)>;
  void DrawVisible(const glm::mat4& clip_from_model, const glm::vec3& eye,
                   const Filter& wanted = nullptr) const;

 private:
  struct Chunk {
    glm::vec3 low;
    glm::vec3 high;
    GLsizei count;
    size_t first;
    float range;  // not drawn from farther away, metres
  };
  void Upload(const Mesh& mesh, const std::vector<uint32_t>& indices);

  std::vector<Chunk> chunks_;
  GlBuffer vertices_;
  GlBuffer indices_;
  GlVertexArray array_;
};

}  // namespace semmap::town
