#include "slam/features/steered_brief.h"

#include <cmath>
#include <numbers>

namespace semmap {
namespace {

constexpr float kAnglesPerRadian = static_cast<float>(SteeredBrief::kAngles / (2.0 * std::numbers::pi));

}  // namespace

SteeredBrief::SteeredBrief(const BriefPattern& pattern) : rotated_(kAngles) {
  for (int i = 0; i < kAngles; ++i) {
    const double angle = i * 2.0 * std::numbers::pi / kAngles;
    const double cosine = std::cos(angle);
    const double sine = std::sin(angle);
    const auto rotate = [&](int point, double x, double y) {
      rotated_[i].x[point] = static_cast<int8_t>(std::lround(cosine * x - sine * y));
      rotated_[i].y[point] = static_cast<int8_t>(std::lround(sine * x + cosine * y));
    };
    for (int bit = 0; bit < kBriefBits; ++bit) {
      rotate(bit, pattern[bit].x1, pattern[bit].y1);
      rotate(kBriefBits + bit, pattern[bit].x2, pattern[bit].y2);
    }
  }
}

void SteeredBrief::Compute(const uint8_t* centre, ptrdiff_t step, float angle, Descriptor* descriptor) const {
  const RotatedPoints& points = rotated_[static_cast<int>(angle * kAnglesPerRadian + 0.5F) % kAngles];
  alignas(64) std::array<int32_t, 2 * kBriefBits> offsets;
  const auto row = static_cast<int32_t>(step);
  for (int i = 0; i < 2 * kBriefBits; ++i) offsets[i] = points.y[i] * row + points.x[i];
  for (int word = 0; word < 4; ++word) {
    const int32_t* first = &offsets[64 * word];
    const int32_t* second = first + kBriefBits;
    uint64_t bits = 0;
    for (int bit = 63; bit >= 0; --bit) {
      bits = bits << 1 | static_cast<uint64_t>(centre[first[bit]] < centre[second[bit]]);
    }
    descriptor->words[word] = bits;
  }
}

}  // namespace semmap
