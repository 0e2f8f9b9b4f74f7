#pragma once

#include <vector>

#include "slam/map/map.h"
#include "slam/pipeline/point_creation.h"

namespace semmap {

// Projects the points into the keyframe; where a keypoint there looks the same, the point gains an
// observation, or, if the keypoint sees another point already, the two become one (the one with more
// observations stays). Returns how many were added or merged.
int FusePoints(const MappingCamera& camera, const std::vector<MapPointId>& points, KeyFrameId keyframe,
               Map* map);

// Fuses both ways between a keyframe and its neighbours: its points into them, theirs into it.
int FuseWithNeighbours(const MappingCamera& camera, KeyFrameId keyframe,
                       const std::vector<KeyFrameId>& neighbours, Map* map);

}  // namespace semmap
