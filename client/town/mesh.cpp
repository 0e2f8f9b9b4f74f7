#include "client/town/mesh.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

namespace semmap::town {
namespace {

int8_t PackSigned(float value) {
  return static_cast<int8_t>(std::lround(std::clamp(value, -1.0F, 1.0F) * 127.0F));
}

glm::vec3 NormalOf(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 cross = glm::cross(b - a, c - a);
  const float length = glm::length(cross);
  return length > 1e-12F ? cross / length : glm::vec3(0, 0, 1);
}

}  // namespace

Surface MakeSurface(Texture texture, ClassId class_id, std::array<uint8_t, 3> tint) {
  Surface surface;
  surface.texture = texture;
  surface.class_id = class_id;
  surface.tint = tint;
  return surface;
}

std::array<uint8_t, 3> Shade(std::array<uint8_t, 3> tint, double factor) {
  for (uint8_t& channel : tint) {
    channel = static_cast<uint8_t>(std::lround(std::clamp(channel * factor, 0.0, 255.0)));
  }
  return tint;
}

void MeshBuilder::Push(Mesh* mesh, const std::array<glm::vec3, 4>& corners,
                       const std::array<glm::vec2, 4>& uv, const std::array<glm::vec2, 4>& grime_uv,
                       const glm::vec3& normal, const Surface& surface) {
  const auto first = static_cast<uint32_t>(mesh->vertices.size());
  for (size_t i = 0; i < 4; ++i) {
    Vertex vertex{};
    vertex.position = corners[i];
    vertex.uv = uv[i];
    vertex.grime_uv = grime_uv[i];
    vertex.normal = {PackSigned(normal.x), PackSigned(normal.y), PackSigned(normal.z), 0};
    vertex.tint = {surface.tint[0], surface.tint[1], surface.tint[2], surface.glow};
    vertex.layer = static_cast<uint8_t>(surface.texture);
    vertex.class_id = static_cast<uint8_t>(surface.class_id);
    vertex.grime = static_cast<uint8_t>(std::clamp(surface.grime, 0.0F, 1.0F) * 255.0F);
    vertex.sun = 2;
    mesh->vertices.push_back(vertex);
  }
  for (const uint32_t offset : {0U, 1U, 2U, 0U, 2U, 3U}) mesh->indices.push_back(first + offset);
}

std::array<glm::vec2, 4> MeshBuilder::GrimeUv(const std::array<glm::vec3, 4>& corners,
                                              const glm::vec3& normal) const {
  glm::vec3 across(1, 0, 0);
  glm::vec3 up(0, 1, 0);
  if (std::abs(normal.z) < 0.7F) {
    across = glm::normalize(glm::vec3(-normal.y, normal.x, 0));
    up = glm::vec3(0, 0, 1);
  }
  // Walls take their stains at a place of their own: the distance of the wall's plane shifts them.
  const float plane = std::abs(normal.z) < 0.7F ? glm::dot(normal, corners[0]) * 1.7F : 0.0F;
  std::array<glm::vec2, 4> result;
  for (size_t i = 0; i < 4; ++i) {
    result[i] =
        glm::vec2(glm::dot(corners[i], across) + plane, glm::dot(corners[i], up) + plane * 0.37F) + shift_;
  }
  return result;
}

void MeshBuilder::Quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d,
                       const Surface& surface) {
  const float metres = surface.metres > 0 ? surface.metres : TileMetres(surface.texture);
  const glm::vec3 normal = NormalOf(a, b, c);
  glm::vec3 across = b - a;
  if (glm::length(across) < 1e-6F) across = c - d;
  across = glm::normalize(across);
  const glm::vec3 up = glm::cross(normal, across);
  // Anchored in the world, so that the courses of neighbouring quads of one wall meet.
  const auto map = [&](const glm::vec3& p) {
    return (glm::vec2(glm::dot(p, across), glm::dot(p, up)) + shift_) / metres;
  };
  const std::array<glm::vec3, 4> corners = {a, b, c, d};
  Push(&solid_, corners, {map(a), map(b), map(c), map(d)}, GrimeUv(corners, normal), normal, surface);
}

void MeshBuilder::QuadUv(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d,
                         const Surface& surface, const glm::vec2& uv_a, const glm::vec2& uv_c) {
  QuadFree({a, b, c, d}, {uv_a, glm::vec2(uv_c.x, uv_a.y), uv_c, glm::vec2(uv_a.x, uv_c.y)}, surface);
}

void MeshBuilder::QuadFree(const std::array<glm::vec3, 4>& corners, const std::array<glm::vec2, 4>& uv,
                           const Surface& surface) {
  const glm::vec3 normal = NormalOf(corners[0], corners[1], corners[2]);
  Push(&solid_, corners, uv, GrimeUv(corners, normal), normal, surface);
}

void MeshBuilder::Triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c,
                           const Surface& surface) {
  Quad(a, b, c, c, surface);
}

void MeshBuilder::CutQuad(const std::array<glm::vec3, 4>& corners, const glm::vec2& uv_a,
                          const glm::vec2& uv_c, const glm::vec3& normal, const Surface& surface) {
  const std::array<glm::vec2, 4> uv = {uv_a, glm::vec2(uv_c.x, uv_a.y), uv_c, glm::vec2(uv_a.x, uv_c.y)};
  Push(&cut_, corners, uv, GrimeUv(corners, NormalOf(corners[0], corners[1], corners[2])), normal, surface);
}

void MeshBuilder::Box(const glm::vec3& base, const glm::vec2& forward, const glm::vec3& size,
                      const Surface& surface, bool with_underside) {
  const glm::vec3 x = glm::vec3(glm::normalize(forward), 0) * (size.x / 2);
  const glm::vec3 y = glm::normalize(glm::vec3(-forward.y, forward.x, 0)) * (size.y / 2);
  const glm::vec3 z(0, 0, size.z);
  const glm::vec3 p00 = base - x - y;
  const glm::vec3 p10 = base + x - y;
  const glm::vec3 p11 = base + x + y;
  const glm::vec3 p01 = base - x + y;
  Quad(p00, p10, p10 + z, p00 + z, surface);
  Quad(p10, p11, p11 + z, p10 + z, surface);
  Quad(p11, p01, p01 + z, p11 + z, surface);
  Quad(p01, p00, p00 + z, p01 + z, surface);
  Quad(p00 + z, p10 + z, p11 + z, p01 + z, surface);
  if (with_underside) Quad(p01, p11, p10, p00, surface);
}

void MeshBuilder::Tube(const glm::vec3& from, const glm::vec3& to, float radius_from, float radius_to,
                       int sides, const Surface& surface, bool capped) {
  const float metres = surface.metres > 0 ? surface.metres : TileMetres(surface.texture);
  const glm::vec3 axis = glm::normalize(to - from);
  const glm::vec3 helper = std::abs(axis.z) < 0.9F ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
  const glm::vec3 x = glm::normalize(glm::cross(helper, axis));
  const glm::vec3 y = glm::cross(axis, x);
  const auto rim = [&](int i) {
    const float angle = glm::two_pi<float>() * static_cast<float>(i) / static_cast<float>(sides);
    return x * std::cos(angle) + y * std::sin(angle);
  };
  const float length = glm::distance(from, to);
  const float turn = glm::two_pi<float>() * radius_from / static_cast<float>(sides);
  for (int i = 0; i < sides; ++i) {
    const glm::vec3 r0 = rim(i);
    const glm::vec3 r1 = rim(i + 1);
    const float u0 = (static_cast<float>(i) * turn + shift_.x) / metres;
    const float u1 = (static_cast<float>(i + 1) * turn + shift_.x) / metres;
    QuadFree(
        {from + r0 * radius_from, from + r1 * radius_from, to + r1 * radius_to, to + r0 * radius_to},
        {glm::vec2(u0, 0), glm::vec2(u1, 0), glm::vec2(u1, length / metres), glm::vec2(u0, length / metres)},
        surface);
    if (capped) Triangle(to, to + r0 * radius_to, to + r1 * radius_to, surface);
  }
}

void MeshBuilder::Sphere(const glm::vec3& centre, const glm::vec3& radii, int slices,
                         const Surface& surface) {
  const int stacks = std::max(2, slices / 2);
  const auto point = [&](int stack, int slice) {
    const float polar = glm::pi<float>() * static_cast<float>(stack) / static_cast<float>(stacks);
    const float azimuth = glm::two_pi<float>() * static_cast<float>(slice) / static_cast<float>(slices);
    return centre + radii * glm::vec3(std::sin(polar) * std::cos(azimuth),
                                      std::sin(polar) * std::sin(azimuth), -std::cos(polar));
  };
  for (int stack = 0; stack < stacks; ++stack) {
    for (int slice = 0; slice < slices; ++slice) {
      Quad(point(stack, slice), point(stack, slice + 1), point(stack + 1, slice + 1), point(stack + 1, slice),
           surface);
    }
  }
}

void MeshBuilder::Ribbon(const std::vector<glm::vec3>& left, const std::vector<glm::vec3>& right,
                         const Surface& surface) {
  const float metres = surface.metres > 0 ? surface.metres : TileMetres(surface.texture);
  float along = shift_.y;
  for (size_t i = 0; i + 1 < std::min(left.size(), right.size()); ++i) {
    const float step = glm::distance(left[i] + right[i], left[i + 1] + right[i + 1]) / 2;
    const float width0 = glm::distance(left[i], right[i]);
    const float width1 = glm::distance(left[i + 1], right[i + 1]);
    const float u = shift_.x;
    QuadFree({right[i], right[i + 1], left[i + 1], left[i]},
             {glm::vec2(u, along) / metres, glm::vec2(u, along + step) / metres,
              glm::vec2(u + width1, along + step) / metres, glm::vec2(u + width0, along) / metres},
             surface);
    along += step;
  }
}

void MeshBuilder::AppendMoved(const MeshBuilder& other, const glm::mat4& transform) {
  const auto append = [&transform](const Mesh& from, Mesh* to) {
    const auto first = static_cast<uint32_t>(to->vertices.size());
    for (Vertex vertex : from.vertices) {
      vertex.position = glm::vec3(transform * glm::vec4(vertex.position, 1));
      const glm::vec3 normal(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
      const glm::vec3 turned = glm::mat3(transform) * (normal / 127.0F);
      vertex.normal = {PackSigned(turned.x), PackSigned(turned.y), PackSigned(turned.z), vertex.normal[3]};
      to->vertices.push_back(vertex);
    }
    for (const uint32_t index : from.indices) to->indices.push_back(first + index);
  };
  append(other.solid_, &solid_);
  append(other.cut_, &cut_);
}

}  // namespace semmap::town
