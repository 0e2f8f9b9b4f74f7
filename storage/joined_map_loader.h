#pragma once

#include <cstddef>

#include "absl/status/statusor.h"
#include "slam/features/frame_features.h"
#include "slam/map/map.h"
#include "storage/map_store.h"

namespace semmap::storage {

// Two maps side by side in one: each in its own frame, with nothing in common yet. The ids of the source's
// keyframes and points have grown by the greatest that the target ever held, as they do in MapRewrite.
struct JoinedMaps {
  MapInfo target;
  MapInfo source;
  Map map;
  size_t memory_bytes = 0;  // give or take a tenth
};

// As LoadMap, of each map as it was at some instant. With `forget_depth` the keypoints know no depth and no
// right eye: for maps of which only one was made with depth.
absl::StatusOr<JoinedMaps> LoadJoinedMaps(MapStore& store, MapId target, MapId source,
                                          const ScalePyramidInfo& scale_info, size_t max_bytes,
                                          const PointClassPolicy& classes, bool forget_depth);

// As one eye would have seen them.
FrameFeatures WithoutDepth(FrameFeatures features);

}  // namespace semmap::storage
