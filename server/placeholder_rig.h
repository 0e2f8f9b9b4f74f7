#pragma once

#include "slam/geometry/camera.h"

namespace semmap::server {

// The store wants to know what a map's first vehicle looks through, which nobody knows of a map that was
// created before any vehicle came. This rig stands in until the first session replaces the empty map by one
// of its own.
inline CameraRig PlaceholderRig() {
  CameraRig rig;
  rig.camera.width = 640;
  rig.camera.height = 480;
  rig.camera.fx = 500;
  rig.camera.fy = 500;
  rig.camera.cx = 320;
  rig.camera.cy = 240;
  return rig;
}

}  // namespace semmap::server
