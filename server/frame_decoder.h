#pragma once

#include "absl/status/statusor.h"
#include "semmap/v1/frame.pb.h"
#include "slam/geometry/camera.h"
#include "slam/pipeline/frame.h"

namespace semmap::server {

// Whether the frame brings just those images that the rig has; cheap, decodes nothing. IMAGE_MISSING,
// IMAGE_UNEXPECTED.
absl::Status CheckImagesPresent(const v1::Frame& frame, SensorType sensor);

// The frame with its images decoded and checked against the rig; with the colours of its image if
// `with_colour` and it does not bring a class mask, which makes them needless. Errors: those of
// CheckImagesPresent and DecodeImage. Thread-safe.
absl::StatusOr<FrameInput> DecodeFrame(const v1::Frame& frame, const CameraRig& rig, bool with_colour);

}  // namespace semmap::server
