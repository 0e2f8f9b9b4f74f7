#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/mat4x4.hpp>
#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "client/town/weather.h"
#include "client/town/world.h"
#include "slam/geometry/camera.h"
#include "slam/geometry/se3.h"

namespace semmap::town {

struct RenderConfig {
  CameraIntrinsics camera;   // without distortion
  float vignetting = 0.25F;  // loss of light in the corners, 0 to 1
  int shadow_size = 6144;    // texels of the map of the still shadows
};

// What the camera sees. Class and depth are those of the surface that covers most of a pixel; colour is
// smoothed over the pixel, so that along edges it mixes both sides.
struct View {
  cv::Mat rgb;    // CV_8UC3, red first
  cv::Mat mask;   // CV_8UC1, ClassId
  cv::Mat depth;  // CV_32FC1, metres along the optical axis, 0 in the sky
};

// One thing that moves: an index returned by AddModel, where it is, and whether it throws a shadow.
struct Instance {
  int model = 0;
  glm::mat4 town_from_model{1.0F};
  bool shadow = true;
};

// Draws one world through one camera. Its thread is the one that calls; a renderer must not be used by two
// threads at once. Same world, same calls: same bytes (of one version of Mesa).
class Renderer {
 public:
  // UNAVAILABLE where there is no off-screen OpenGL.
  static absl::StatusOr<std::unique_ptr<Renderer>> Create(const World& world, const RenderConfig& config,
                                                          const Weather& weather);
  ~Renderer();

  // Keeps a mesh to be drawn by its index.
  int AddModel(const MeshBuilder& mesh);

  // `frame` seeds the sensor's noise. The camera frame is x right, y down, z forward.
  absl::Status Render(const SE3& town_from_camera, const std::vector<Instance>& instances, uint32_t frame,
                      View* view);

  const std::string& device() const;

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace semmap::town
