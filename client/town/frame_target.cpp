#include "client/town/frame_target.h"

#include <array>

#include "absl/status/status.h"

namespace semmap::town {
namespace {
constexpr std::array<GLenum, 2> kBothTargets = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
}

absl::StatusOr<FrameTarget> FrameTarget::Create(int width, int height) {
  FrameTarget target;
  target.width_ = width;
  target.height_ = height;
  const auto plain = [&](GLenum format) {
    GlTexture texture = MakeTexture(GL_TEXTURE_2D);
    glTextureStorage2D(texture.get(), 1, format, width, height);
    return texture;
  };
  target.scene_colour_ = plain(GL_RGBA8);
  target.scene_z_ = plain(GL_DEPTH_COMPONENT32F);
  // The sensor looks between pixels; at the rim it sees the outermost ones again.
  glTextureParameteri(target.scene_colour_.get(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(target.scene_colour_.get(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(target.scene_colour_.get(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  target.scene_ = MakeFramebuffer();
  glNamedFramebufferTexture(target.scene_.get(), GL_COLOR_ATTACHMENT0, target.scene_colour_.get(), 0);
  glNamedFramebufferTexture(target.scene_.get(), GL_DEPTH_ATTACHMENT, target.scene_z_.get(), 0);
  target.colour_ = plain(GL_RGBA8);
  target.depth_ = plain(GL_R32F);
  target.pixels_ = MakeFramebuffer();
  glNamedFramebufferTexture(target.pixels_.get(), GL_COLOR_ATTACHMENT0, target.colour_.get(), 0);
  glNamedFramebufferTexture(target.pixels_.get(), GL_COLOR_ATTACHMENT1, target.depth_.get(), 0);
  glNamedFramebufferDrawBuffers(target.pixels_.get(), static_cast<GLsizei>(kBothTargets.size()),
                                kBothTargets.data());
  for (const GLuint name : {target.scene_.get(), target.pixels_.get()}) {
    if (glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      return absl::UnavailableError("this OpenGL cannot draw to colour and depth");
    }
  }
  return target;
}

void FrameTarget::BeginScene() const {
  glBindFramebuffer(GL_FRAMEBUFFER, scene_.get());
  glViewport(0, 0, width_, height_);
  glClear(GL_DEPTH_BUFFER_BIT);  // the sky covers whatever nothing else does
}

void FrameTarget::BeginSensor() const {
  glBindFramebuffer(GL_FRAMEBUFFER, pixels_.get());
  glViewport(0, 0, width_, height_);
  glBindTextureUnit(4, scene_colour_.get());
  glBindTextureUnit(5, scene_z_.get());
}

void FrameTarget::Read(cv::Mat* colour_class, cv::Mat* depth) const {
  colour_class->create(height_, width_, CV_8UC4);
  depth->create(height_, width_, CV_32FC1);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, pixels_.get());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, colour_class->data);
  glReadBuffer(GL_COLOR_ATTACHMENT1);
  glReadPixels(0, 0, width_, height_, GL_RED, GL_FLOAT, depth->data);
}

}  // namespace semmap::town
