#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/features/descriptor.h"
#include "slam/features/orb_pattern.h"

namespace semmap {

// Steered BRIEF (Rublee et al., ORB, ICCV 2011, section 4.1): the pattern is rotated by the keypoint's
// orientation, in steps, before its tests are made on the smoothed image. Immutable after construction;
// thread-safe.
class SteeredBrief {
 public:
  // `step`: bytes from one row of the smoothed images to the next.
  SteeredBrief(const BriefPattern& pattern, ptrdiff_t step);

  // `centre` points into an 8-bit smoothed image with at least kBriefReach pixels on every side; angle in
  // radians, [0, 2 pi].
  void Compute(const uint8_t* centre, float angle, Descriptor* descriptor) const;

 private:
  // For every angle: the byte offsets of the first points of all tests, then those of the second points.
  std::vector<int32_t> offsets_;
};

}  // namespace semmap
