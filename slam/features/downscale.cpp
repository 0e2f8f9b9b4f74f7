#include "slam/features/downscale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#ifdef __SSSE3__
#include <tmmintrin.h>
#endif

namespace semmap {
namespace {

// Weights have six bits: with eight the products of the byte-wise multiply-add could overflow.
constexpr int kWeightBits = 6;
constexpr int kUnit = 1 << kWeightBits;
constexpr int kHalf = kUnit / 2;
constexpr int kOctet = 8;
constexpr int kVectorBytes = 16;

uint8_t Blend(int first, int second, int second_weight) {
  return static_cast<uint8_t>((first * (kUnit - second_weight) + second * second_weight + kHalf) >>
                              kWeightBits);
}

void BlendRows(const uint8_t* first, const uint8_t* second, int second_weight, int count,
               uint8_t* __restrict to) {
  const int first_weight = kUnit - second_weight;
  for (int x = 0; x < count; ++x) {
    const auto sum = static_cast<uint16_t>(first_weight * first[x] + second_weight * second[x] + kHalf);
    to[x] = static_cast<uint8_t>(sum >> kWeightBits);
  }
}

}  // namespace

Downscaler::Downscaler(const cv::Size& from, const cv::Size& to)
    : to_size_(to), columns_(MakeTaps(from.width, to.width)), rows_(MakeTaps(from.height, to.height)) {
  row_.resize(static_cast<size_t>(from.width) + kVectorBytes);
  MakeOctets();
}

std::vector<Downscaler::Tap> Downscaler::MakeTaps(int from, int to) {
  std::vector<Tap> taps(to);
  for (int i = 0; i < to; ++i) {
    const double place = std::clamp((i + 0.5) * from / to - 0.5, 0.0, from - 1.0);
    taps[i].first = std::min(static_cast<int>(place), std::max(0, from - 2));
    taps[i].second_weight = from == 1 ? 0 : static_cast<int>(std::lround((place - taps[i].first) * kUnit));
  }
  return taps;
}

void Downscaler::MakeOctets() {
  for (size_t x = 0; x + kOctet <= columns_.size(); x += kOctet) {
    Octet octet;
    octet.base = columns_[x].first;
    if (columns_[x + kOctet - 1].first + 1 - octet.base >= kVectorBytes) return;
    for (int i = 0; i < kOctet; ++i) {
      const Tap& tap = columns_[x + i];
      octet.shuffle[2 * i] = static_cast<uint8_t>(tap.first - octet.base);
      octet.shuffle[2 * i + 1] = static_cast<uint8_t>(tap.first - octet.base + 1);
      octet.weights[2 * i] = static_cast<uint8_t>(kUnit - tap.second_weight);
      octet.weights[2 * i + 1] = static_cast<uint8_t>(tap.second_weight);
    }
    octets_.push_back(octet);
  }
}

void Downscaler::ScaleRow(const uint8_t* from, uint8_t* to) const {
  size_t x = 0;
#ifdef __SSSE3__
  const __m128i half = _mm_set1_epi16(kHalf);
  for (const Octet& octet : octets_) {
    const __m128i source = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + octet.base));
    const __m128i pairs =
        _mm_shuffle_epi8(source, _mm_load_si128(reinterpret_cast<const __m128i*>(octet.shuffle.data())));
    const __m128i sums =
        _mm_maddubs_epi16(pairs, _mm_load_si128(reinterpret_cast<const __m128i*>(octet.weights.data())));
    const __m128i rounded = _mm_srli_epi16(_mm_add_epi16(sums, half), kWeightBits);
    _mm_storel_epi64(reinterpret_cast<__m128i*>(to + x), _mm_packus_epi16(rounded, rounded));
    x += kOctet;
  }
#endif
  for (; x < columns_.size(); ++x) {
    const Tap& tap = columns_[x];
    to[x] = Blend(from[tap.first], from[tap.first + 1], tap.second_weight);
  }
}

void Downscaler::Scale(const cv::Mat& from, cv::Mat* to) {
  for (int y = 0; y < to_size_.height; ++y) {
    const Tap& tap = rows_[y];
    const uint8_t* first = from.ptr(tap.first);
    const uint8_t* second = tap.first + 1 < from.rows ? from.ptr(tap.first + 1) : first;
    BlendRows(first, second, tap.second_weight, from.cols, row_.data());
    ScaleRow(row_.data(), to->ptr(y));
  }
}

}  // namespace semmap
