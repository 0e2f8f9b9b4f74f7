#pragma once

#include <cstdint>
#include <span>

#include "slam/features/descriptor.h"

namespace semmap {

// The nearest of many descriptors and the distance of the next nearest, for a ratio test. Of equally near
// ones the first counts.
struct NearestTwo {
  static constexpr int kNoDistance = 257;  // more than two descriptors can differ

  int index = -1;  // position among the candidates; -1: there were none
  int distance = kNoDistance;
  int second_distance = kNoDistance;

  friend bool operator==(const NearestTwo&, const NearestTwo&) = default;
};

// Exhaustive search among descriptors that lie in one piece. Several at once where the CPU counts bits of
// vectors (AVX-512 VPOPCNTDQ), otherwise one by one. Thread-safe.
NearestTwo FindNearestTwo(const Descriptor& query, std::span<const Descriptor> candidates);

// The same among descriptors[indices[i]]; `index` of the result is i.
NearestTwo FindNearestTwo(const Descriptor& query, std::span<const Descriptor> descriptors,
                          std::span<const int> indices);

}  // namespace semmap
