#pragma once

#include "slam/geometry/camera.h"
#include "slam/optimize/observation.h"
#include "slam/pipeline/association.h"

namespace semmap {

// What mapping, relocalization and loop closing need to know of the camera and of how what it sees is
// matched.
struct MappingCamera {
  CameraRig rig;
  ImageBounds bounds;
  ProjectionModel model;
  // Points up to this depth tell where the camera is (TrackingConfig::close_depth_in_baselines); 0: unknown,
  // as with one eye.
  double near_depth = 0;
  AssociationRule association = {};

  bool HasDepth() const { return rig.sensor != SensorType::kMono; }
};

}  // namespace semmap
