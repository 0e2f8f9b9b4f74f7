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
  const auto multisample = [&](GLenum format) {
    GlTexture texture = MakeTexture(GL_TEXTURE_2D_MULTISAMPLE);
    glTextureStorage2DMultisample(texture.get(), kSamplesPerPixel, format, width, height, GL_TRUE);
    return texture;
  };
  const auto plain = [&](GLenum format) {
    GlTexture texture = MakeTexture(GL_TEXTURE_2D);
    glTextureStorage2D(texture.get(), 1, format, width, height);
    return texture;
  };
  target.sample_colour_ = multisample(GL_RGBA8);
  target.sample_z_ = multisample(GL_DEPTH_COMPONENT32F);
  target.samples_ = MakeFramebuffer();
  glNamedFramebufferTexture(target.samples_.get(), GL_COLOR_ATTACHMENT0, target.sample_colour_.get(), 0);
  glNamedFramebufferTexture(target.samples_.get(), GL_DEPTH_ATTACHMENT, target.sample_z_.get(), 0);
  target.colour_ = plain(GL_RGBA8);
  target.depth_ = plain(GL_R32F);
  target.pixels_ = MakeFramebuffer();
  glNamedFramebufferTexture(target.pixels_.get(), GL_COLOR_ATTACHMENT0, target.colour_.get(), 0);
  glNamedFramebufferTexture(target.pixels_.get(), GL_COLOR_ATTACHMENT1, target.depth_.get(), 0);
  glNamedFramebufferDrawBuffers(target.pixels_.get(), static_cast<GLsizei>(kBothTargets.size()),
                                kBothTargets.data());
  for (const GLuint name : {target.samples_.get(), target.pixels_.get()}) {
    if (glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      return absl::UnavailableError("this OpenGL cannot draw to 4 samples of colour and depth");
    }
  }
  return target;
}

void FrameTarget::BeginScene() const {
  glBindFramebuffer(GL_FRAMEBUFFER, samples_.get());
  glViewport(0, 0, width_, height_);
  glClear(GL_DEPTH_BUFFER_BIT);  // the sky covers whatever nothing else does
}

void FrameTarget::BeginSensor() const {
  glBindFramebuffer(GL_FRAMEBUFFER, pixels_.get());
  glViewport(0, 0, width_, height_);
  glBindTextureUnit(4, sample_colour_.get());
  glBindTextureUnit(5, sample_z_.get());
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
