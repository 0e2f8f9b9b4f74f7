#pragma once

#include <cstddef>
#include <functional>

#include "slam/map/map.h"
#include "slam/optimize/observation.h"

namespace semmap {

// How far keypoints lie from the projections of the points that they see, pixels of the full image.
struct ReprojectionError {
  double rms_px = 0;
  size_t observations = 0;
};

// Of all observations of the active points that `admits` (none given: of all). Points behind a camera have no
// projection and do not count.
ReprojectionError MeasureReprojection(const Map& map, const ProjectionModel& model,
                                      const std::function<bool(const MapPoint&)>& admits = nullptr);

}  // namespace semmap
