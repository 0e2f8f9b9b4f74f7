#pragma once

#include <vector>

#include "slam/map/map.h"
#include "slam/pipeline/point_creation.h"

namespace semmap {

// How far a keypoint may be from a point's projection: the search window in pixels of octave 0, and the error
// that is accepted in units of the bound that 95 % of true pairs keep.
struct FusionTolerance {
  float radius = 3;
  float error_factor = 1;
};

// Projects the points into the keyframe, which must be active; where a keypoint there looks the same, the
// point gains an observation, or, if the keypoint sees another point already, the two become one (the one
// with more observations stays). Returns how many were added or merged.
int FusePoints(const MappingCamera& camera, const std::vector<MapPointId>& points, KeyFrameId keyframe,
               const FusionTolerance& tolerance, Map* map);

// One such step: keypoint `keypoint` of the keyframe shows the point. False when it was known, when the
// keyframe sees the point elsewhere, and when the keypoint sees an inactive point.
bool JoinPoint(MapPointId point, KeyFrameId keyframe, int keypoint, Map* map);

// Each active point once, in the order of the keyframes.
std::vector<MapPointId> PointsSeenBy(const Map& map, const std::vector<KeyFrameId>& keyframes);

// Fuses both ways between a keyframe and its neighbours: its points into them, theirs into it.
int FuseWithNeighbours(const MappingCamera& camera, KeyFrameId keyframe,
                       const std::vector<KeyFrameId>& neighbours, Map* map);

// Looks for the inactive points of the neighbours in the keyframe: where a keypoint that sees no point looks
// like one of them, the point gains an observation and with it a vote, by which it may become active. Returns
// how many did.
int ObserveInactivePoints(const MappingCamera& camera, KeyFrameId keyframe,
                          const std::vector<KeyFrameId>& neighbours, Map* map);

}  // namespace semmap
