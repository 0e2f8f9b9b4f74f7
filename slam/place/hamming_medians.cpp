#include "slam/place/hamming_medians.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <random>

#include "slam/features/descriptor_search.h"

namespace semmap {
namespace {

constexpr int kBits = 256;
constexpr uint32_t kNoCluster = ~0U;

// How many descriptors have each bit.
class BitCounts {
 public:
  void Add(const Descriptor& descriptor) {
    for (int word = 0; word < kBits / 64; ++word) {
      for (int bit = 0; bit < 64; ++bit) {
        ones_[64 * word + bit] += static_cast<uint32_t>((descriptor.words[word] >> bit) & 1U);
      }
    }
    ++total_;
  }

  bool empty() const { return total_ == 0; }

  // Where as many have a bit as have it not, it stays as in `before`.
  Descriptor Majority(const Descriptor& before) const {
    Descriptor majority;
    for (int bit = 0; bit < kBits; ++bit) {
      const uint64_t tie = (before.words[bit / 64] >> (bit % 64)) & 1U;
      const uint64_t value = 2 * ones_[bit] == total_ ? tie : uint64_t{2 * ones_[bit] > total_};
      majority.words[bit / 64] |= value << (bit % 64);
    }
    return majority;
  }

 private:
  std::array<uint32_t, kBits> ones_{};
  uint32_t total_ = 0;
};

// Index of the entry into which `target` falls when weights are laid end to end.
size_t DrawByWeight(const std::vector<uint32_t>& weights, uint64_t target) {
  size_t i = 0;
  while (target >= weights[i]) target -= weights[i++];
  return i;
}

std::vector<Descriptor> DrawCentres(std::span<const Descriptor> points, int count, std::mt19937_64& random) {
  std::vector<Descriptor> centres = {points[random() % points.size()]};
  // Square of the distance to the nearest centre.
  std::vector<uint32_t> weights(points.size(), kNoCluster);
  while (true) {
    uint64_t sum = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const auto distance = static_cast<uint32_t>(HammingDistance(points[i], centres.back()));
      weights[i] = std::min(weights[i], distance * distance);
      sum += weights[i];
    }
    if (sum == 0 || centres.size() == static_cast<size_t>(count)) return centres;
    centres.push_back(points[DrawByWeight(weights, random() % sum)]);
  }
}

// Says whether anything changed.
bool Assign(std::span<const Descriptor> points, Medians* medians) {
  bool changed = false;
  for (size_t i = 0; i < points.size(); ++i) {
    const auto nearest = static_cast<uint32_t>(FindNearestTwo(points[i], medians->centres).index);
    changed |= medians->cluster_of[i] != nearest;
    medians->cluster_of[i] = nearest;
  }
  return changed;
}

void MoveCentres(std::span<const Descriptor> points, Medians* medians) {
  std::vector<BitCounts> counts(medians->centres.size());
  for (size_t i = 0; i < points.size(); ++i) counts[medians->cluster_of[i]].Add(points[i]);
  for (size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i].empty()) medians->centres[i] = counts[i].Majority(medians->centres[i]);
  }
}

void DropEmptyClusters(Medians* medians) {
  std::vector<uint32_t> renumbered(medians->centres.size(), kNoCluster);
  for (const uint32_t cluster : medians->cluster_of) renumbered[cluster] = 0;
  std::vector<Descriptor> kept;
  for (size_t i = 0; i < renumbered.size(); ++i) {
    if (renumbered[i] == kNoCluster) continue;
    renumbered[i] = static_cast<uint32_t>(kept.size());
    kept.push_back(medians->centres[i]);
  }
  for (uint32_t& cluster : medians->cluster_of) cluster = renumbered[cluster];
  medians->centres = std::move(kept);
}

}  // namespace

Medians ClusterByMedians(std::span<const Descriptor> points, const MediansConfig& config) {
  std::mt19937_64 random(config.seed);
  Medians medians;
  medians.centres = DrawCentres(points, config.clusters, random);
  medians.cluster_of.assign(points.size(), kNoCluster);
  for (int i = 0; Assign(points, &medians) && i < config.max_iterations; ++i) MoveCentres(points, &medians);
  DropEmptyClusters(&medians);
  return medians;
}

}  // namespace semmap
