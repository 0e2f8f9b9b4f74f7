#pragma once

#include <cstdint>

#if defined(__AVX512BW__) || defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#else
#include <algorithm>
#include <array>
#endif

namespace semmap {

// As many unsigned bytes as the CPU that is compiled for handles at once, with the few operations that corner
// detection needs. Results do not depend on the width.
class ByteVector {
 public:
#if defined(__AVX512BW__)
  static constexpr int kLanes = 64;
  using Mask = uint64_t;  // bit i belongs to lane i

  static ByteVector Load(const uint8_t* from) { return ByteVector(_mm512_loadu_si512(from)); }
  static ByteVector All(uint8_t value) { return ByteVector(_mm512_set1_epi8(static_cast<char>(value))); }
  void Store(uint8_t* to) const { _mm512_storeu_si512(to, lanes_); }

  friend ByteVector Min(ByteVector a, ByteVector b) {
    return ByteVector(_mm512_min_epu8(a.lanes_, b.lanes_));
  }
  friend ByteVector Max(ByteVector a, ByteVector b) {
    return ByteVector(_mm512_max_epu8(a.lanes_, b.lanes_));
  }
  // (a + b + 1) / 2.
  friend ByteVector Average(ByteVector a, ByteVector b) {
    return ByteVector(_mm512_avg_epu8(a.lanes_, b.lanes_));
  }
  // a - b, or 0 where that is negative.
  friend ByteVector Excess(ByteVector a, ByteVector b) {
    return ByteVector(_mm512_subs_epu8(a.lanes_, b.lanes_));
  }
  friend Mask Greater(ByteVector a, ByteVector b) { return _mm512_cmpgt_epu8_mask(a.lanes_, b.lanes_); }
#elif defined(__AVX2__)
  static constexpr int kLanes = 32;
  using Mask = uint32_t;

  static ByteVector Load(const uint8_t* from) {
    return ByteVector(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
  }
  static ByteVector All(uint8_t value) { return ByteVector(_mm256_set1_epi8(static_cast<char>(value))); }
  void Store(uint8_t* to) const { _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), lanes_); }

  friend ByteVector Min(ByteVector a, ByteVector b) {
    return ByteVector(_mm256_min_epu8(a.lanes_, b.lanes_));
  }
  friend ByteVector Max(ByteVector a, ByteVector b) {
    return ByteVector(_mm256_max_epu8(a.lanes_, b.lanes_));
  }
  // (a + b + 1) / 2.
  friend ByteVector Average(ByteVector a, ByteVector b) {
    return ByteVector(_mm256_avg_epu8(a.lanes_, b.lanes_));
  }
  friend ByteVector Excess(ByteVector a, ByteVector b) {
    return ByteVector(_mm256_subs_epu8(a.lanes_, b.lanes_));
  }
  friend Mask Greater(ByteVector a, ByteVector b) {
    const __m256i not_greater =
        _mm256_cmpeq_epi8(_mm256_subs_epu8(a.lanes_, b.lanes_), _mm256_setzero_si256());
    return ~static_cast<uint32_t>(_mm256_movemask_epi8(not_greater));
  }
#elif defined(__SSE2__)
  static constexpr int kLanes = 16;
  using Mask = uint16_t;

  static ByteVector Load(const uint8_t* from) {
    return ByteVector(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
  }
  static ByteVector All(uint8_t value) { return ByteVector(_mm_set1_epi8(static_cast<char>(value))); }
  void Store(uint8_t* to) const { _mm_storeu_si128(reinterpret_cast<__m128i*>(to), lanes_); }

  friend ByteVector Min(ByteVector a, ByteVector b) { return ByteVector(_mm_min_epu8(a.lanes_, b.lanes_)); }
  friend ByteVector Max(ByteVector a, ByteVector b) { return ByteVector(_mm_max_epu8(a.lanes_, b.lanes_)); }
  // (a + b + 1) / 2.
  friend ByteVector Average(ByteVector a, ByteVector b) {
    return ByteVector(_mm_avg_epu8(a.lanes_, b.lanes_));
  }
  friend ByteVector Excess(ByteVector a, ByteVector b) {
    return ByteVector(_mm_subs_epu8(a.lanes_, b.lanes_));
  }
  friend Mask Greater(ByteVector a, ByteVector b) {
    const __m128i not_greater = _mm_cmpeq_epi8(_mm_subs_epu8(a.lanes_, b.lanes_), _mm_setzero_si128());
    return static_cast<Mask>(~_mm_movemask_epi8(not_greater));
  }
#else
  static constexpr int kLanes = 16;
  using Mask = uint16_t;

  static ByteVector Load(const uint8_t* from) {
    return Lanewise([&](int lane) { return from[lane]; });
  }
  static ByteVector All(uint8_t value) {
    return Lanewise([&](int) { return value; });
  }
  void Store(uint8_t* to) const { std::copy(lanes_.begin(), lanes_.end(), to); }

  friend ByteVector Min(const ByteVector& a, const ByteVector& b) {
    return Lanewise([&](int lane) { return std::min(a.lanes_[lane], b.lanes_[lane]); });
  }
  friend ByteVector Max(const ByteVector& a, const ByteVector& b) {
    return Lanewise([&](int lane) { return std::max(a.lanes_[lane], b.lanes_[lane]); });
  }
  friend ByteVector Average(const ByteVector& a, const ByteVector& b) {
    return Lanewise(
        [&](int lane) { return static_cast<uint8_t>((a.lanes_[lane] + b.lanes_[lane] + 1) / 2); });
  }
  friend ByteVector Excess(const ByteVector& a, const ByteVector& b) {
    return Lanewise(
        [&](int lane) { return static_cast<uint8_t>(std::max(a.lanes_[lane] - b.lanes_[lane], 0)); });
  }
  friend Mask Greater(const ByteVector& a, const ByteVector& b) {
    unsigned mask = 0;
    for (int lane = 0; lane < kLanes; ++lane) mask |= unsigned{a.lanes_[lane] > b.lanes_[lane]} << lane;
    return static_cast<Mask>(mask);
  }
#endif

  static ByteVector Zero() { return All(0); }

 private:
#if defined(__AVX512BW__)
  using Lanes = __m512i;
#elif defined(__AVX2__)
  using Lanes = __m256i;
#elif defined(__SSE2__)
  using Lanes = __m128i;
#else
  using Lanes = std::array<uint8_t, kLanes>;
  template <typename Function>
  static ByteVector Lanewise(Function&& function) {
    Lanes lanes;
    for (int lane = 0; lane < kLanes; ++lane) lanes[lane] = function(lane);
    return ByteVector(lanes);
  }
#endif
  explicit ByteVector(Lanes lanes) : lanes_(lanes) {}

  Lanes lanes_;
};

}  // namespace semmap
