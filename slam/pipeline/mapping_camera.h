#pragma once

#include "slam/geometry/camera.h"
#include "slam/optimize/observation.h"

namespace semmap {

// What mapping, relocalization and loop closing need to know of the camera.
struct MappingCamera {
  CameraRig rig;
  ImageBounds bounds;
  ProjectionModel model;

  bool HasDepth() const { return rig.sensor != SensorType::kMono; }
};

}  // namespace semmap
