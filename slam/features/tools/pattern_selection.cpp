#include "slam/features/tools/pattern_selection.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <random>
#include <set>
#include <utility>

namespace semmap {
namespace {

using Bits = std::vector<uint64_t>;

struct Candidate {
  int first = 0;
  int second = 0;
  Bits bits;  // outcome for every patch
  double mean = 0;
  double instability = 0;
  double cost = 0;
};

Bits Compare(const std::vector<uint8_t>& first, const std::vector<uint8_t>& second) {
  Bits bits(first.size() / 64);
  for (size_t i = 0; i < bits.size() * 64; ++i) bits[i / 64] |= uint64_t{first[i] < second[i]} << (i % 64);
  return bits;
}

template <typename Combine>
double ShareOfOnes(const Bits& a, const Bits& b, Combine&& combine) {
  int64_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) count += std::popcount(combine(a[i], b[i]));
  return static_cast<double>(count) / (64.0 * static_cast<double>(a.size()));
}

double Correlation(const Candidate& a, const Candidate& b) {
  const double both = ShareOfOnes(a.bits, b.bits, [](uint64_t p, uint64_t q) { return p & q; });
  const double deviation = std::sqrt(a.mean * (1 - a.mean) * b.mean * (1 - b.mean));
  return deviation > 0 ? std::abs(both - a.mean * b.mean) / deviation : 1.0;
}

std::vector<Candidate> DrawCandidates(const PatchSamples& samples, const PatternSelectionConfig& config) {
  std::mt19937 random(config.seed);
  const auto places = static_cast<uint32_t>(samples.places.size());
  const size_t wanted = std::min<size_t>(config.candidates, size_t{places} * (places - 1) / 2);
  std::set<std::pair<uint32_t, uint32_t>> pairs;
  while (pairs.size() < wanted) {
    const auto a = static_cast<uint32_t>(random() % places);
    const auto b = static_cast<uint32_t>(random() % places);
    if (a != b) pairs.insert({std::min(a, b), std::max(a, b)});
  }
  std::vector<Candidate> candidates;
  for (const auto& [first, second] : pairs) {
    Candidate& candidate = candidates.emplace_back();
    candidate.first = static_cast<int>(first);
    candidate.second = static_cast<int>(second);
  }
  return candidates;
}

void Rate(const PatchSamples& samples, double instability_weight, Candidate* candidate) {
  candidate->bits = Compare(samples.original[candidate->first], samples.original[candidate->second]);
  const Bits again = Compare(samples.distorted[candidate->first], samples.distorted[candidate->second]);
  candidate->mean = ShareOfOnes(candidate->bits, candidate->bits, [](uint64_t p, uint64_t) { return p; });
  candidate->instability = ShareOfOnes(candidate->bits, again, [](uint64_t p, uint64_t q) { return p ^ q; });
  // 2 p (1 - p): how often the bits of two different patches differ.
  candidate->cost = instability_weight * candidate->instability - 2 * candidate->mean * (1 - candidate->mean);
}

std::vector<const Candidate*> TakeUncorrelated(const std::vector<Candidate>& ordered,
                                               double max_correlation) {
  std::vector<const Candidate*> taken;
  for (const Candidate& candidate : ordered) {
    const bool independent = std::all_of(taken.begin(), taken.end(), [&](const Candidate* other) {
      return Correlation(candidate, *other) < max_correlation;
    });
    if (independent) taken.push_back(&candidate);
    if (taken.size() == kBriefBits) break;
  }
  return taken;
}

}  // namespace

PatternSelection SelectPattern(const PatchSamples& samples, const PatternSelectionConfig& config) {
  std::vector<Candidate> candidates = DrawCandidates(samples, config);
  for (Candidate& candidate : candidates) Rate(samples, config.instability_weight, &candidate);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  PatternSelection selection;
  selection.max_correlation = config.first_correlation;
  std::vector<const Candidate*> taken = TakeUncorrelated(candidates, selection.max_correlation);
  while (taken.size() < kBriefBits && selection.max_correlation < 1.0 + config.correlation_step) {
    selection.max_correlation += config.correlation_step;
    taken = TakeUncorrelated(candidates, selection.max_correlation);
  }
  for (size_t i = 0; i < taken.size(); ++i) {
    const PatchSamples::Place& first = samples.places[taken[i]->first];
    const PatchSamples::Place& second = samples.places[taken[i]->second];
    selection.pattern[i] = {first.x, first.y, second.x, second.y};
    selection.mean_instability += taken[i]->instability / kBriefBits;
  }
  return selection;
}

}  // namespace semmap
