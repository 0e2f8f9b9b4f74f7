#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/features/descriptor.h"
#include "slam/features/orb_pattern.h"

namespace semmap {

// Steered BRIEF (Rublee et al., ORB, ICCV 2011, section 4.1): the pattern is rotated by the keypoint's
// orientation, rounded to one of kAngles, before its tests are made on the smoothed image. Immutable after
// construction; thread-safe.
class SteeredBrief {
 public:
  // ORB's thirty steps cost a few percent of the matches against exact angles, 256 next to none.
  static constexpr int kAngles = 256;

  explicit SteeredBrief(const BriefPattern& pattern);

  // `centre` points into an 8-bit smoothed image, rows `step` bytes apart, with at least kBriefRadius pixels
  // on every side and one more to the right; angle in radians, [0, 2 pi].
  void Compute(const uint8_t* centre, ptrdiff_t step, float angle, Descriptor* descriptor) const;

 private:
  // Places in the patch, as row * 32 + column from its top left corner: the first points of all tests, then
  // the second.
  using RotatedPoints = std::array<uint16_t, 2 * kBriefBits>;

  std::vector<RotatedPoints> rotated_;  // by angle
};

}  // namespace semmap
