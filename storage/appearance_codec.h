#pragma once

#include "absl/status/status.h"
#include "slam/map/map_delta.h"
#include "storage/byte_buffer.h"

// Packed form of what only the algorithm reads of a map point; what queries select by are columns of their
// own. Direction and distances lose what no use of them can tell: they bound from where a point is looked
// for, with margins of tens of percent. To pack what was unpacked loses nothing more.
//
//   format                      uint8, 2
//   normal                      2 int16: its place on an unfolded octahedron, to 1/32767 of an edge
//                               (octahedral map; Meyer et al., "On Floating-Point Normal Vectors", 2010);
//                               INT16_MIN twice: of no length
//   min_distance, max_distance  2 int16: 1024 steps to a doubling, 0 is 1 unit of the map;
//                               INT16_MIN: not positive
//   descriptor                  32 bytes
//   votes                       varint count, each uint8 class and varint count
//
// Format 1, of maps stored earlier, had floats for the normal (3) and the distances (2); it is still read.
namespace semmap::storage {

constexpr size_t kMaxClassVotes = 256;

// Replaces what `out` held. point.votes has at most kMaxClassVotes members; normal and distances are finite.
void EncodeAppearance(const MapPointRecord& point, ByteWriter* out);
// Fills those members of `point`; DATA_LOSS for bytes that EncodeAppearance did not write.
absl::Status DecodeAppearance(BlobView bytes, MapPointRecord* point);

// The point that is read when this one was stored.
MapPointRecord AsStored(MapPointRecord point);

}  // namespace semmap::storage
