#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/common/ids.h"
#include "storage/byte_buffer.h"

// Which keypoints of a keyframe are kept. A keypoint costs 43 bytes, most of them its descriptor, and an
// image has some 2,000; those that see a map point localize the next vehicle, the others serve to recognize
// the place and to find new points, for which fewer do.
namespace semmap::storage {

// Ascending indices of the keypoints to keep, of `count`: all that see a point, and others up to `at_most` in
// total, taken at equal steps from the list. (Extraction lists keypoints level by level and cell by cell, so
// that equal steps spread over scales and the image; how strong a corner was nobody knows any more.)
// point_of_keypoint is empty or `count` long.
std::vector<uint32_t> SelectKeypoints(size_t count, std::span<const MapPointId> point_of_keypoint,
                                      size_t at_most);

// Packed form of a set of indices below `count`; the empty one stands for all of them.
//
//   format    uint8, 1 or 2
//   checksum  uint64, XXH3 of the rest
//   count     varint
//   1 bits    a bit for each of `count`, lowest first
//   2 gaps    varint number of indices; each: varint, indices left out since the last one
// whichever is shorter.
Blob EncodeIndexSet(size_t count, std::span<const uint32_t> indices);
// DATA_LOSS for bytes that EncodeIndexSet did not write for `count`.
absl::StatusOr<std::vector<uint32_t>> DecodeIndexSet(BlobView bytes, size_t count);

}  // namespace semmap::storage
