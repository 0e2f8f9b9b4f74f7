#pragma once

#include <string>
#include <utility>

#include <epoxy/gl.h>

#include "absl/status/statusor.h"

namespace semmap::town {

// Owners of OpenGL names. They are made and destroyed while their context is current.
template <void (*Delete)(GLuint)>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  ~GlName() { Reset(); }
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    if (this != &other) {
      Reset();
      name_ = std::exchange(other.name_, 0);
    }
    return *this;
  }
  GLuint get() const { return name_; }

 private:
  void Reset() {
    if (name_ != 0) Delete(name_);
    name_ = 0;
  }
  GLuint name_ = 0;
};

namespace gl_internal {
inline void DeleteTexture(GLuint name) { glDeleteTextures(1, &name); }
inline void DeleteBuffer(GLuint name) { glDeleteBuffers(1, &name); }
inline void DeleteVertexArray(GLuint name) { glDeleteVertexArrays(1, &name); }
inline void DeleteFramebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
inline void DeleteProgram(GLuint name) { glDeleteProgram(name); }
inline void DeleteShader(GLuint name) { glDeleteShader(name); }
}  // namespace gl_internal

using GlTexture = GlName<gl_internal::DeleteTexture>;
using GlBuffer = GlName<gl_internal::DeleteBuffer>;
using GlVertexArray = GlName<gl_internal::DeleteVertexArray>;
using GlFramebuffer = GlName<gl_internal::DeleteFramebuffer>;
using GlProgram = GlName<gl_internal::DeleteProgram>;
using GlShader = GlName<gl_internal::DeleteShader>;

GlTexture MakeTexture(GLenum target);
GlBuffer MakeBuffer(GLsizeiptr bytes, const void* data);
GlVertexArray MakeVertexArray();
GlFramebuffer MakeFramebuffer();

// INTERNAL with the compiler's log when the sources do not compile or link.
absl::StatusOr<GlProgram> MakeProgram(const std::string& vertex_source, const std::string& fragment_source);

}  // namespace semmap::town
