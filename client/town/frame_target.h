#pragma once

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "client/town/gl_objects.h"

namespace semmap::town {

// The images that one frame is drawn into: the scene as the shaders leave it, then what the sensor makes of
// it, from which it is read back.
class FrameTarget {
 public:
  static absl::StatusOr<FrameTarget> Create(int width, int height);

  // Following draws go to the scene, which is cleared.
  void BeginScene() const;
  // Following draws go to the pixels; the scene's colour and depth are bound to texture units 4 and 5.
  void BeginSensor() const;
  // CV_8UC4 (RGB and class) and CV_32FC1, top row first.
  void Read(cv::Mat* colour_class, cv::Mat* depth) const;

 private:
  FrameTarget() = default;

  int width_ = 0;
  int height_ = 0;
  GlTexture scene_colour_;
  GlTexture scene_z_;
  GlFramebuffer scene_;
  GlTexture colour_;
  GlTexture depth_;
  GlFramebuffer pixels_;
};

}  // namespace semmap::town
