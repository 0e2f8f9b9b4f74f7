#include "client/town/gl_objects.h"

#include <array>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap::town {
namespace {

absl::StatusOr<GlShader> Compile(GLenum kind, const std::string& source) {
  GlShader shader(glCreateShader(kind));
  const char* text = source.c_str();
  glShaderSource(shader.get(), 1, &text, nullptr);
  glCompileShader(shader.get());
  GLint ok = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  std::array<char, 2048> log{};
  glGetShaderInfoLog(shader.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return absl::InternalError(absl::StrCat("shader does not compile: ", log.data()));
}

}  // namespace

GlTexture MakeTexture(GLenum target) {
  GLuint name = 0;
  glCreateTextures(target, 1, &name);
  return GlTexture(name);
}

GlBuffer MakeBuffer(GLsizeiptr bytes, const void* data) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  glNamedBufferStorage(name, bytes, data, 0);
  return GlBuffer(name);
}

GlVertexArray MakeVertexArray() {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  return GlVertexArray(name);
}

GlFramebuffer MakeFramebuffer() {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  return GlFramebuffer(name);
}

absl::StatusOr<GlProgram> MakeProgram(const std::string& vertex_source, const std::string& fragment_source) {
  SEMMAP_ASSIGN_OR_RETURN(const GlShader vertex, Compile(GL_VERTEX_SHADER, vertex_source));
  SEMMAP_ASSIGN_OR_RETURN(const GlShader fragment, Compile(GL_FRAGMENT_SHADER, fragment_source));
  GlProgram program(glCreateProgram());
  glAttachShader(program.get(), vertex.get());
  glAttachShader(program.get(), fragment.get());
  glLinkProgram(program.get());
  GLint ok = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return program;
  std::array<char, 2048> log{};
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return absl::InternalError(absl::StrCat("program does not link: ", log.data()));
}

}  // namespace semmap::town
