#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace semmap {

// 256 binary intensity comparisons around an oriented keypoint (Rublee et al., ORB, ICCV 2011).
// Bit i is bit i % 64 of word i / 64.
struct alignas(32) Descriptor {
  std::array<uint64_t, 4> words{};

  friend bool operator==(const Descriptor&, const Descriptor&) = default;
};
static_assert(sizeof(Descriptor) == 32);

// Number of differing bits, 0 to 256.
inline int HammingDistance(const Descriptor& a, const Descriptor& b) {
  return std::popcount(a.words[0] ^ b.words[0]) + std::popcount(a.words[1] ^ b.words[1]) +
         std::popcount(a.words[2] ^ b.words[2]) + std::popcount(a.words[3] ^ b.words[3]);
}

}  // namespace semmap
