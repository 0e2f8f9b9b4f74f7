#pragma once

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "client/town/gl_objects.h"

namespace semmap::town {

inline constexpr int kSamplesPerPixel = 4;

// The images that one frame is drawn into: several samples a pixel for colour with class and for depth, then
// one of each, from which they are read back.
class FrameTarget {
 public:
  static absl::StatusOr<FrameTarget> Create(int width, int height);

  // Following draws go to the samples, which are cleared.
  void BeginScene() const;
  // Following draws go to the pixels; the samples are bound to texture units 4 and 5.
  void BeginSensor() const;
  // CV_8UC4 (RGB and class) and CV_32FC1, top row first.
  void Read(cv::Mat* colour_class, cv::Mat* depth) const;

 private:
  FrameTarget() = default;

  int width_ = 0;
  int height_ = 0;
  GlTexture sample_colour_;
  GlTexture sample_z_;
  GlFramebuffer samples_;
  GlTexture colour_;
  GlTexture depth_;
  GlFramebuffer pixels_;
};

}  // namespace semmap::town
