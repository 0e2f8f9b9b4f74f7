#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "slam/common/ids.h"
#include "storage/byte_buffer.h"

// Packed form of which map point each keypoint of a keyframe sees: about three bytes for each that sees one.
//
//   format   uint8, 1
//   varint   keypoints
//   varint   observations
//   each     varint: keypoints without a point since the last one; signed varint: its id minus the last one's
namespace semmap::storage {

// At most kMaxKeypoints entries, ids below 2^63. Replaces what `out` held; returns the number of
// observations.
uint32_t EncodeObservations(const std::vector<MapPointId>& point_of_keypoint, ByteWriter* out);
// DATA_LOSS for bytes that EncodeObservations did not write.
absl::StatusOr<std::vector<MapPointId>> DecodeObservations(BlobView bytes);
// The same, the points alone, in the order of the keypoints that see them.
absl::StatusOr<std::vector<MapPointId>> DecodeSeenPoints(BlobView bytes);

}  // namespace semmap::storage
