#include "slam/features/steered_brief.h"

#include <cmath>
#include <numbers>

#ifdef __AVX512VBMI__
#include <immintrin.h>
#endif

namespace semmap {
namespace {

constexpr float kAnglesPerRadian = static_cast<float>(SteeredBrief::kAngles / (2.0 * std::numbers::pi));
// The patch has 31 rows and columns; with rows of 32 its places are numbers of ten bits.
constexpr int kPatchSide = 2 * kBriefRadius + 1;
constexpr int kRowBits = 5;
constexpr int kRowPlaces = 1 << kRowBits;
static_assert(kPatchSide == kRowPlaces - 1);
constexpr int kWordBits = 64;

#ifdef __AVX512VBMI__
// The whole patch in sixteen registers, from which 64 places are read at once.
class PatchReader {
 public:
  PatchReader(const uint8_t* centre, ptrdiff_t step) {
    const uint8_t* row = centre - kBriefRadius * step - kBriefRadius;
    for (int i = 0; i < kPatchSide / 2; ++i, row += 2 * step) {
      rows_[i] = _mm512_inserti64x4(_mm512_castsi256_si512(LoadRow(row)), LoadRow(row + step), 1);
    }
    rows_[kPatchSide / 2] = _mm512_zextsi256_si512(LoadRow(row));
  }

  // Bit i: is the pixel at first[i] below that at second[i]?
  uint64_t Compare(const uint16_t* first, const uint16_t* second) const {
    return _mm512_cmplt_epu8_mask(Read(first), Read(second));
  }

 private:
  static __m256i LoadRow(const uint8_t* row) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row));
  }

  // The seven low bits of a place choose one of 128 bytes of a pair of registers, the others the pair.
  __m512i Read(const uint16_t* places) const {
    const __m512i low_half = _mm512_loadu_si512(places);
    const __m512i high_half = _mm512_loadu_si512(places + kWordBits / 2);
    const __m512i byte = _mm512_inserti64x4(_mm512_castsi256_si512(_mm512_cvtepi16_epi8(low_half)),
                                            _mm512_cvtepi16_epi8(high_half), 1);
    const auto lanes_with = [&](int bit) {
      const __m512i mask = _mm512_set1_epi16(static_cast<int16_t>(1 << bit));
      return _mm512_kunpackd(_mm512_test_epi16_mask(high_half, mask), _mm512_test_epi16_mask(low_half, mask));
    };
    const auto from_pair = [&](int pair) {
      return _mm512_permutex2var_epi8(rows_[2 * pair], byte, rows_[2 * pair + 1]);
    };
    const __mmask64 odd = lanes_with(7);
    const __mmask64 second = lanes_with(8);
    const auto from_two = [&](int pair) {
      return _mm512_mask_blend_epi8(odd, from_pair(pair), from_pair(pair + 1));
    };
    return _mm512_mask_blend_epi8(lanes_with(9), _mm512_mask_blend_epi8(second, from_two(0), from_two(2)),
                                  _mm512_mask_blend_epi8(second, from_two(4), from_two(6)));
  }

  __m512i rows_[kRowPlaces / 2];
};
#else
class PatchReader {
 public:
  PatchReader(const uint8_t* centre, ptrdiff_t step)
      : corner_(centre - kBriefRadius * step - kBriefRadius), step_(static_cast<int32_t>(step)) {}

  uint64_t Compare(const uint16_t* first, const uint16_t* second) const {
    // Apart from the reads, so that the compiler vectorizes it.
    std::array<int32_t, 2 * kWordBits> offsets;
    for (int i = 0; i < kWordBits; ++i) {
      offsets[i] = Offset(first[i]);
      offsets[kWordBits + i] = Offset(second[i]);
    }
    uint64_t bits = 0;
    for (int i = kWordBits - 1; i >= 0; --i) {
      bits = bits << 1 | static_cast<uint64_t>(corner_[offsets[i]] < corner_[offsets[kWordBits + i]]);
    }
    return bits;
  }

 private:
  int32_t Offset(int32_t place) const { return (place >> kRowBits) * step_ + (place & (kRowPlaces - 1)); }

  const uint8_t* corner_;
  int32_t step_;
};
#endif

}  // namespace

SteeredBrief::SteeredBrief(const BriefPattern& pattern) : rotated_(kAngles) {
  for (int i = 0; i < kAngles; ++i) {
    const double angle = i * 2.0 * std::numbers::pi / kAngles;
    const double cosine = std::cos(angle);
    const double sine = std::sin(angle);
    const auto rotated_place = [&](double x, double y) {
      const auto column = static_cast<int>(std::lround(cosine * x - sine * y)) + kBriefRadius;
      const auto row = static_cast<int>(std::lround(sine * x + cosine * y)) + kBriefRadius;
      return static_cast<uint16_t>(row * kRowPlaces + column);
    };
    for (int bit = 0; bit < kBriefBits; ++bit) {
      rotated_[i][bit] = rotated_place(pattern[bit].x1, pattern[bit].y1);
      rotated_[i][kBriefBits + bit] = rotated_place(pattern[bit].x2, pattern[bit].y2);
    }
  }
}

void SteeredBrief::Compute(const uint8_t* centre, ptrdiff_t step, float angle, Descriptor* descriptor) const {
  const RotatedPoints& points = rotated_[static_cast<int>(angle * kAnglesPerRadian + 0.5F) % kAngles];
  const PatchReader patch(centre, step);
  for (size_t word = 0; word < descriptor->words.size(); ++word) {
    const uint16_t* first = points.data() + kWordBits * word;
    descriptor->words[word] = patch.Compare(first, first + kBriefBits);
  }
}

}  // namespace semmap
