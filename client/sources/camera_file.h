#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "slam/geometry/camera.h"

namespace semmap::client {

// Reads a calibration, in YAML (config/cameras has examples):
//
//   width: 1241                   # pixels; required
//   height: 376
//   fx: 718.856                   # pixels; required
//   fy: 718.856
//   cx: 607.1928                  # the centre of the top-left pixel is (0, 0); required
//   cy: 185.2157
//   distortion_model: none        # none | radial_tangential | equidistant
//   distortion: []                # k1 k2 p1 p2 [k3], or the k1 k2 k3 k4 of equidistant
//   baseline_m: 0.5372            # stereo: required; the right camera lies this far along +x
//   depth_units_per_metre: 1000   # RGB-D: 1000 for millimetres, 5000 for TUM
//   frames_per_second: 10
//   body_from_camera: [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]   # 4x4, row by row
//
// NOT_FOUND, or INVALID_ARGUMENT naming file, line and key; the rig is valid for `sensor`.
absl::StatusOr<CameraRig> ReadCameraFile(const std::string& path, SensorType sensor);

}  // namespace semmap::client
