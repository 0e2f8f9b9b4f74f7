#pragma once

#include <array>
#include <cstdint>

namespace semmap {

// One bit of a BRIEF descriptor: is the smoothed intensity at the first offset below that at the second?
// Offsets in pixels from the keypoint, x right, y down, for a patch whose orientation is 0.
struct BriefTest {
  int8_t x1 = 0;
  int8_t y1 = 0;
  int8_t x2 = 0;
  int8_t y2 = 0;

  friend bool operator==(const BriefTest&, const BriefTest&) = default;
};

constexpr int kBriefBits = 256;
// No offset of a test is longer than this, so that a rotated and rounded one is within it in x and in y.
constexpr int kBriefRadius = 15;

using BriefPattern = std::array<BriefTest, kBriefBits>;

// The pattern of every descriptor of this project; stored maps depend on it.
const BriefPattern& OrbPattern();

// Points drawn from an isotropic Gaussian with a standard deviation of a fifth of the patch, as Calonder et
// al. (BRIEF, ECCV 2010, distribution GII) recommend: the baseline that a trained pattern has to beat.
BriefPattern GaussianPattern(uint32_t seed);

}  // namespace semmap
