#pragma once

#include "absl/status/statusor.h"
#include "slam/features/frame_features.h"
#include "storage/byte_buffer.h"

// Packed form of a keyframe's keypoints and descriptors, exact to the last bit.
//
//   format    uint8, 1
//   count     uint32, keypoints
//   columns   x, y, right_x, depth, angle (float), octave, semantic_class (uint8), each as
//               0 constant   the one value
//               1 raw        count values
//               2 sparse     a frequent value, a bit for each keypoint (1: another value), the other values
//             whichever is shortest: a monocular keyframe pays nothing for depth, one without masks nothing
//             for classes
//   descriptors  32 bytes each
namespace semmap::storage {

// A keyframe never has more; decoders refuse more before they allocate.
constexpr size_t kMaxKeypoints = 65535;

// features.keypoints and .descriptors are equally long, at most kMaxKeypoints. Replaces what `out` held.
void EncodeFeatures(const FrameFeatures& features, ByteWriter* out);
// DATA_LOSS for bytes that EncodeFeatures did not write.
absl::StatusOr<FrameFeatures> DecodeFeatures(BlobView bytes);

}  // namespace semmap::storage
