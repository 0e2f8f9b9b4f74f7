#include "slam/features/steered_brief.h"

#include <cmath>
#include <numbers>

namespace semmap {
namespace {

constexpr int kAngles = 64;
constexpr int kOffsetsPerAngle = 2 * kBriefBits;
constexpr float kAnglesPerRadian = static_cast<float>(kAngles / (2.0 * std::numbers::pi));

}  // namespace

SteeredBrief::SteeredBrief(const BriefPattern& pattern, ptrdiff_t step) {
  offsets_.resize(static_cast<size_t>(kAngles) * kOffsetsPerAngle);
  for (int i = 0; i < kAngles; ++i) {
    const double angle = i * 2.0 * std::numbers::pi / kAngles;
    const double cosine = std::cos(angle);
    const double sine = std::sin(angle);
    const auto rotated_offset = [&](double x, double y) {
      return static_cast<int32_t>(std::lround(sine * x + cosine * y) * step +
                                  std::lround(cosine * x - sine * y));
    };
    int32_t* first = &offsets_[static_cast<size_t>(i) * kOffsetsPerAngle];
    for (int bit = 0; bit < kBriefBits; ++bit) {
      first[bit] = rotated_offset(pattern[bit].x1, pattern[bit].y1);
      first[kBriefBits + bit] = rotated_offset(pattern[bit].x2, pattern[bit].y2);
    }
  }
}

void SteeredBrief::Compute(const uint8_t* centre, float angle, Descriptor* descriptor) const {
  const int nearest = static_cast<int>(angle * kAnglesPerRadian + 0.5F) % kAngles;
  const int32_t* first = &offsets_[static_cast<size_t>(nearest) * kOffsetsPerAngle];
  const int32_t* second = first + kBriefBits;
  for (int word = 0; word < 4; ++word) {
    uint64_t bits = 0;
    for (int bit = 63; bit >= 0; --bit) {
      const int test = 64 * word + bit;
      bits = bits << 1 | static_cast<uint64_t>(centre[first[test]] < centre[second[test]]);
    }
    descriptor->words[word] = bits;
  }
}

}  // namespace semmap
