#pragma once

#include "slam/geometry/camera.h"

namespace semmap::server {

// Whether pixels of one, undistorted, are pixels of the other.
bool SameIntrinsics(const CameraRig& a, const CameraRig& b);

// Whether keyframes of one can be projected as if the other had taken them, the second eye included.
bool SameCameras(const CameraRig& a, const CameraRig& b);

}  // namespace semmap::server
