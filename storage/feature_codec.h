#pragma once

#include <cstdint>
#include <span>

#include "absl/status/statusor.h"
#include "slam/features/frame_features.h"
#include "storage/byte_buffer.h"

// Packed form of keypoints and descriptors of a keyframe. Keypoints lose what no use of them can tell:
// positions are kept to 1/32 of a pixel (a corner is located to about half a pixel), depths to 1/4096 of
// themselves, angles to 1/256 of a turn. Descriptors, octaves and classes are exact. To pack what was
// unpacked loses nothing more.
//
//   format       uint8, 2
//   checksum     uint64, XXH3 of the rest
//   count        varint, keypoints
//   columns      x, y, right_x, depth, angle, octave, semantic_class as integers, each as
//                  0 constant  signed varint
//                  1 dense     signed varint base, uint8 width; for each keypoint `width` bytes: value - base
//                  2 sparse    signed varint frequent value, then base and width, a bit for each keypoint
//                              (1: another value), the other values
//                whichever is shortest: a monocular keyframe pays nothing for depth, one without masks
//                nothing for classes
//   descriptors  32 bytes each
//
// Format 1, which the first schema version wrote, kept floats to the last bit and had no checksum; it is
// still read.
namespace semmap::storage {

// A keyframe never has more; decoders refuse more before they allocate.
constexpr size_t kMaxKeypoints = 65535;

// features.keypoints and .descriptors are equally long, at most kMaxKeypoints, all numbers finite; `indices`
// says which of them to pack. Replaces what `out` held.
void EncodeFeatures(const FrameFeatures& features, std::span<const uint32_t> indices, ByteWriter* out);
// DATA_LOSS for bytes that EncodeFeatures did not write.
absl::StatusOr<FrameFeatures> DecodeFeatures(BlobView bytes);

// The values that DecodeFeatures answers when these are encoded.
Keypoint AsStored(const Keypoint& keypoint);

}  // namespace semmap::storage
