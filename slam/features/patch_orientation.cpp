#include "slam/features/patch_orientation.h"

#include <array>
#include <cmath>
#include <numbers>

namespace semmap {
namespace {

// A row of the disc is read as 32 pixels from -15 to 16; the mask blanks those outside the disc.
constexpr int kLanes = 32;
using LaneMask = std::array<uint8_t, kLanes>;

constexpr std::array<LaneMask, kOrientationRadius + 1> MakeDisc() {
  std::array<LaneMask, kOrientationRadius + 1> disc{};
  for (int y = 0; y <= kOrientationRadius; ++y) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const int x = lane - kOrientationRadius;
      // Half a pixel is added to the radius so that the disc looks the same in x and y.
      disc[y][lane] = 4 * (x * x + y * y) <= (2 * kOrientationRadius + 1) * (2 * kOrientationRadius + 1) &&
                              x <= kOrientationRadius
                          ? 255
                          : 0;
    }
  }
  return disc;
}
constexpr std::array<LaneMask, kOrientationRadius + 1> kDisc = MakeDisc();

}  // namespace

float IntensityCentroidAngle(const uint8_t* centre, ptrdiff_t step) {
  // Sums for each column stay within 16 bits: 31 * 255 for the intensities, (1 + ... + 15) * 255 when
  // weighted by y.
  alignas(64) std::array<int16_t, kLanes> intensity;
  alignas(64) std::array<int16_t, kLanes> weighted_by_y;
  const uint8_t* middle = centre - kOrientationRadius;
  for (int lane = 0; lane < kLanes; ++lane) {
    intensity[lane] = static_cast<int16_t>(middle[lane] & kDisc[0][lane]);
    weighted_by_y[lane] = 0;
  }
  for (int y = 1; y <= kOrientationRadius; ++y) {
    const uint8_t* below = middle + y * step;
    const uint8_t* above = middle - y * step;
    for (int lane = 0; lane < kLanes; ++lane) {
      const auto lower = static_cast<int16_t>(below[lane] & kDisc[y][lane]);
      const auto upper = static_cast<int16_t>(above[lane] & kDisc[y][lane]);
      intensity[lane] = static_cast<int16_t>(intensity[lane] + lower + upper);
      weighted_by_y[lane] = static_cast<int16_t>(weighted_by_y[lane] + y * (lower - upper));
    }
  }
  int moment_x = 0;
  int moment_y = 0;
  for (int lane = 0; lane < kLanes; ++lane) {
    moment_x += (lane - kOrientationRadius) * intensity[lane];
    moment_y += weighted_by_y[lane];
  }
  const float angle = std::atan2(static_cast<float>(moment_y), static_cast<float>(moment_x));
  constexpr auto kTurn = static_cast<float>(2.0 * std::numbers::pi);
  // Adding a turn to a tiny negative angle rounds to the turn itself.
  const float positive = angle < 0 ? angle + kTurn : angle;
  return positive < kTurn ? positive : 0.0F;
}

}  // namespace semmap
