#pragma once

#include <atomic>

#include "slam/map/map.h"
#include "slam/pipeline/mapping_camera.h"

namespace semmap {

struct OptimizeResult {
  // Root mean square reprojection error, pixels: of all observations before, and of those that are left.
  double initial_rms_px = 0;
  double final_rms_px = 0;
  int iterations = 0;
  size_t removed_observations = 0;
  bool stopped = false;  // the map is then as it was
};

// Bundle adjustment of a whole map that nobody else has, with at most so many iterations. The first keyframe
// stays where it is.
OptimizeResult OptimizeWholeMap(int max_iterations, const MappingCamera& camera,
                                const std::atomic<bool>* stop, Map* map);

}  // namespace semmap
