#pragma once

#include <cstddef>

#include "absl/status/statusor.h"
#include "slam/map/map.h"
#include "slam/pipeline/map_overlap.h"
#include "slam/pipeline/mapping_camera.h"

namespace semmap {

// What a map may keep; 0: no bound.
struct PruneBudget {
  size_t max_keyframes = 0;
  size_t max_points = 0;
};

struct PruneResult {
  size_t removed_keyframes = 0;
  size_t removed_points = 0;  // those that went with keyframes included
};

// Brings a map down to a budget in such a way that it stays one in which places are found. First the
// keyframes that tell least go: as for CullKeyFrames, points that others see at least as well tell nothing,
// but here a point counts by the share of the three others that it has, so that keyframes are told apart, and
// thinned out evenly, far below the threshold of culling. The first keyframe stays, frames go to heirs. Then
// the points that are seen by fewest keyframes (of equal ones those that are less sure of their class), those
// of no use for locating first; keyframes keep enough points to be found by as long as the budget allows.
absl::StatusOr<PruneResult> PruneToBudget(const PruneBudget& budget, const MappingCamera& camera, Map* map,
                                          const StepVisitor& visit);

}  // namespace semmap
