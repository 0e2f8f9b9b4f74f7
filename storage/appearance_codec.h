#pragma once

#include "absl/status/status.h"
#include "slam/map/map_delta.h"
#include "storage/byte_buffer.h"

// Packed form of what only the algorithm reads of a map point; what queries select by are columns of their
// own.
//
//   format                      uint8, 1
//   normal                      3 floats
//   min_distance, max_distance  2 floats
//   descriptor                  32 bytes
//   votes                       varint count, each uint8 class and varint count
namespace semmap::storage {

constexpr size_t kMaxClassVotes = 256;

// Replaces what `out` held. point.votes has at most kMaxClassVotes members.
void EncodeAppearance(const MapPointRecord& point, ByteWriter* out);
// Fills those members of `point`; DATA_LOSS for bytes that EncodeAppearance did not write.
absl::Status DecodeAppearance(BlobView bytes, MapPointRecord* point);

}  // namespace semmap::storage
