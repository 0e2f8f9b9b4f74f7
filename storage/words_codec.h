#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/byte_buffer.h"

// Packed form of the words that a keyframe's keypoints fell on, with repetitions: a little over a byte each.
// Weights follow from the vocabulary and are not kept.
//
//   format    uint8, 1
//   checksum  uint64, XXH3 of the rest
//   count     varint
//   each      varint: the word minus the last one
namespace semmap::storage {

// `words` ascend. Replaces what `out` held.
void EncodeWords(std::span<const uint32_t> words, ByteWriter* out);
// DATA_LOSS for bytes that EncodeWords did not write.
absl::StatusOr<std::vector<uint32_t>> DecodeWords(BlobView bytes);

}  // namespace semmap::storage
