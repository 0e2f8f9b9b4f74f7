#include "slam/features/descriptor_search.h"

#include <algorithm>
#include <cstddef>

#if defined(__AVX512VPOPCNTDQ__) && defined(__AVX512F__)
#include <immintrin.h>
#define SEMMAP_VECTOR_POPCOUNT 1
#endif

namespace semmap {
namespace {

// Takes one candidate more into account.
void Consider(int index, int distance, NearestTwo* nearest) {
  if (distance < nearest->distance) {
    nearest->second_distance = nearest->distance;
    nearest->distance = distance;
    nearest->index = index;
  } else {
    nearest->second_distance = std::min(nearest->second_distance, distance);
  }
}

#ifdef SEMMAP_VECTOR_POPCOUNT
constexpr size_t kDescriptorsAtOnce = 8;
// Distance and position in one number, so that the least is the nearest and, of equally near ones, the first.
constexpr int kPositionBits = 32;

// Keeps the two nearest in each of eight lanes.
class LanewiseNearest {
 public:
  explicit LanewiseNearest(const Descriptor& query)
      : query_(_mm512_broadcast_i64x4(LoadDescriptor(query))),
        best_(_mm512_set1_epi64(int64_t{NearestTwo::kNoDistance} << kPositionBits)),
        second_(best_) {}

  // Eight candidates, `candidate(i)` being the i-th.
  template <typename Candidate>
  void Add(size_t first_position, Candidate&& candidate) {
    const auto differing_bits = [&](size_t i) {
      const __m512i two = _mm512_inserti64x4(_mm512_castsi256_si512(LoadDescriptor(candidate(i))),
                                             LoadDescriptor(candidate(i + 1)), 1);
      return _mm512_popcnt_epi64(_mm512_xor_si512(query_, two));
    };
    // Halves of candidates 0 2 | 0 2 | 1 3 | 1 3, and of 4 6 | 4 6 | 5 7 | 5 7.
    const __m512i low = AddPairs(differing_bits(0), differing_bits(2));
    const __m512i high = AddPairs(differing_bits(4), differing_bits(6));
    const __m512i distance =
        _mm512_add_epi64(_mm512_shuffle_i64x2(low, high, 0x88), _mm512_shuffle_i64x2(low, high, 0xDD));
    const __m512i position = _mm512_add_epi64(_mm512_set1_epi64(static_cast<int64_t>(first_position)),
                                              _mm512_set_epi64(7, 5, 6, 4, 3, 1, 2, 0));
    const __m512i key = _mm512_or_si512(_mm512_slli_epi64(distance, kPositionBits), position);
    second_ = _mm512_min_epu64(second_, _mm512_max_epu64(best_, key));
    best_ = _mm512_min_epu64(best_, key);
  }

  NearestTwo Result() const {
    const uint64_t best = _mm512_reduce_min_epu64(best_);
    // The second is the least of what lost in its lane and the bests of the other lanes.
    const __mmask8 winner = _mm512_cmpeq_epu64_mask(best_, _mm512_set1_epi64(static_cast<int64_t>(best)));
    const uint64_t second = _mm512_reduce_min_epu64(_mm512_mask_mov_epi64(best_, winner, second_));
    NearestTwo nearest;
    nearest.distance = static_cast<int>(best >> kPositionBits);
    nearest.second_distance = static_cast<int>(second >> kPositionBits);
    if (nearest.distance < NearestTwo::kNoDistance) nearest.index = static_cast<int>(best & 0xFFFFFFFF);
    return nearest;
  }

 private:
  static __m256i LoadDescriptor(const Descriptor& descriptor) {
    return _mm256_load_si256(reinterpret_cast<const __m256i*>(descriptor.words.data()));
  }
  static __m512i AddPairs(__m512i a, __m512i b) {
    return _mm512_add_epi64(_mm512_unpacklo_epi64(a, b), _mm512_unpackhi_epi64(a, b));
  }

  __m512i query_;
  __m512i best_;
  __m512i second_;
};
#endif

template <typename Candidate>
NearestTwo Search(const Descriptor& query, size_t count, Candidate&& candidate) {
  NearestTwo nearest;
  size_t i = 0;
#ifdef SEMMAP_VECTOR_POPCOUNT
  if (count >= kDescriptorsAtOnce) {
    LanewiseNearest lanes(query);
    for (; i + kDescriptorsAtOnce <= count; i += kDescriptorsAtOnce) {
      lanes.Add(i, [&](size_t lane) -> const Descriptor& { return candidate(i + lane); });
    }
    nearest = lanes.Result();
  }
#endif
  for (; i < count; ++i) Consider(static_cast<int>(i), HammingDistance(query, candidate(i)), &nearest);
  return nearest;
}

}  // namespace

NearestTwo FindNearestTwo(const Descriptor& query, std::span<const Descriptor> candidates) {
  return Search(query, candidates.size(), [&](size_t i) -> const Descriptor& { return candidates[i]; });
}

NearestTwo FindNearestTwo(const Descriptor& query, std::span<const Descriptor> descriptors,
                          std::span<const int> indices) {
  return Search(query, indices.size(),
                [&](size_t i) -> const Descriptor& { return descriptors[indices[i]]; });
}

}  // namespace semmap
