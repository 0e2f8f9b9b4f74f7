#pragma once

#include <atomic>

#include "slam/map/map.h"
#include "slam/optimize/bundle_adjustment.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// Adjusts the keyframe, its best covisible neighbours and all points they see; keyframes on the rim that see
// these points hold them in place. Observations that end as outliers are removed. `stop` may end it early
// (its result so far is kept).
BundleSummary AdjustLocalMap(const MappingConfig& config, const ProjectionModel& model, KeyFrameId keyframe,
                             const std::atomic<bool>* stop, Map* map);

// Adjusts everything; the first keyframe holds the map's frame.
BundleSummary AdjustWholeMap(const MappingConfig& config, const ProjectionModel& model, Map* map);

}  // namespace semmap
