#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "semmap/v1/camera.pb.h"
#include "slam/geometry/camera.h"

namespace semmap::server {

// A rig as the algorithm takes it, defaults filled in. Everything that cannot be a rig is RIG_INVALID with
// the field's name, more than `max_pixels` IMAGE_TOO_LARGE.
absl::StatusOr<CameraRig> RigFromProto(const v1::CameraRig& proto, int64_t max_pixels);

v1::CameraRig ToProto(const CameraRig& rig);

}  // namespace semmap::server
