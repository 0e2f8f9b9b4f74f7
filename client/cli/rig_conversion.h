#pragma once

#include "semmap/v1/camera.pb.h"
#include "semmap/v1/pose.pb.h"
#include "slam/geometry/camera.h"

namespace semmap::client {

v1::Pose ToProto(const SE3& pose);
v1::CameraRig ToProto(const CameraRig& rig);

// A pose message as the server sends it; identity when parts are absent.
SE3 FromProto(const v1::Pose& pose);

}  // namespace semmap::client
