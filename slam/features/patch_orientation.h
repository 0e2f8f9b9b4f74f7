#pragma once

#include <cstddef>
#include <cstdint>

namespace semmap {

// Radius of the disc whose intensity centroid gives a keypoint its orientation.
constexpr int kOrientationRadius = 15;

// Direction in radians, [0, 2 pi), from `centre` to the intensity centroid of the disc around it (Rosin 1999;
// Rublee et al. 2011, section 3.2); x right, y down, so that angles grow clockwise as seen. 0 for a patch
// without one. `step` is the distance between rows in bytes; kOrientationRadius + 1 pixels around the centre
// must be readable.
float IntensityCentroidAngle(const uint8_t* centre, ptrdiff_t step);

}  // namespace semmap
