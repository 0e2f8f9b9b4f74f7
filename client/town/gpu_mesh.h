#pragma once

#include <array>
#include <vector>

#include <glm/mat4x4.hpp>

#include "client/town/gl_objects.h"
#include "client/town/mesh.h"

namespace semmap::town {

// A mesh on the GPU, its triangles grouped by place so that what the camera cannot see is left out.
class GpuMesh {
 public:
  GpuMesh() = default;
  // Groups of `cell` metres; 0: all in one.
  GpuMesh(const Mesh& mesh, float cell);

  bool empty() const { return chunks_.empty(); }
  void DrawAll() const;
  // Draws the groups that may lie in the view, near ones first.
  void DrawVisible(const glm::mat4& clip_from_model, const glm::vec3& eye) const;

 private:
  struct Chunk {
    glm::vec3 low;
    glm::vec3 high;
    GLsizei count;
    size_t first;
  };
  void Upload(const Mesh& mesh, const std::vector<uint32_t>& indices);

  std::vector<Chunk> chunks_;
  GlBuffer vertices_;
  GlBuffer indices_;
  GlVertexArray array_;
};

}  // namespace semmap::town
