#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "slam/features/descriptor.h"

namespace semmap {

struct MediansConfig {
  int clusters = 10;  // at least 1
  int max_iterations = 12;
  uint64_t seed = 1;
};

struct Medians {
  // Each is the majority of its points bit by bit, which is their median in Hamming space. No cluster is
  // empty; there are fewer than asked for when there are fewer different points.
  std::vector<Descriptor> centres;
  std::vector<uint32_t> cluster_of;  // by point: the nearest centre's
};

// k-medians: Lloyd's iterations from centres drawn as in k-means++ (Arthur and Vassilvitskii, SODA 2007),
// which prefers points far from the centres it has. The same for one seed on every machine. `points` not
// empty.
Medians ClusterByMedians(std::span<const Descriptor> points, const MediansConfig& config);

}  // namespace semmap
