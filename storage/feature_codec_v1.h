#pragma once

#include "absl/status/statusor.h"
#include "slam/features/frame_features.h"
#include "storage/byte_buffer.h"

// How the first schema version packed features; read only, for databases that were migrated. Exact to the
// last bit.
//
//   format       uint8, 1
//   count        uint32, keypoints
//   columns      x, y, right_x, depth, angle (float), octave, semantic_class (uint8), each as
//                  0 constant  the one value
//                  1 raw       count values
//                  2 sparse    a frequent value, a bit for each keypoint (1: another value), the other values
//   descriptors  32 bytes each
namespace semmap::storage {

constexpr uint8_t kFeatureFormatV1 = 1;

// DATA_LOSS for bytes that are not of this format.
absl::StatusOr<FrameFeatures> DecodeFeaturesV1(BlobView bytes);

}  // namespace semmap::storage
