#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/place/vocabulary_tree.h"

namespace semmap {

// The file of a vocabulary, made to be mapped into memory as it is. All numbers are little-endian:
//
//   offset  size          what
//   0       8             "SEMMAPVC"
//   8       4             version, 1
//   12      4 4 4 4       branching, levels, direct level, training images
//   28      4 4           nodes, words
//   36      4             0
//   40      8             XXH3 (64 bit, seed 0) of all bytes of the file but these eight
//   48      16            0
//   64      32 * nodes    centres, four 64-bit words each
//           8 * nodes     first, children
//           4 * words     idf, IEEE 754 single precision

// The bytes of a file.
std::string EncodeVocabulary(const VocabularyView& vocabulary);

// Looks at the bytes of a file, which must outlive the answer and begin at a multiple of 32.
// INVALID_ARGUMENT: another kind or version of file. DATA_LOSS: cut off or damaged.
absl::StatusOr<VocabularyView> DecodeVocabulary(std::span<const std::byte> bytes);

// The digest within the bytes of a file that DecodeVocabulary accepts.
uint64_t DigestOf(std::span<const std::byte> bytes);

// Replaces the file at once: whoever has the old one open keeps the old one.
absl::Status WriteVocabulary(const std::string& path, const VocabularyView& vocabulary);

}  // namespace semmap
