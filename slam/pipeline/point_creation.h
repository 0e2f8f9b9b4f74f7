#pragma once

#include <vector>

#include "slam/map/map.h"
#include "slam/pipeline/mapping_camera.h"

namespace semmap {

// Makes a point of every keypoint of the keyframe that has depth, sees no point yet and is close (or among
// the hundred nearest). Returns the new points.
std::vector<MapPointId> CreatePointsFromDepth(const MappingCamera& camera, double close_depth_m,
                                              KeyFrameId keyframe, Map* map);

// Triangulates keypoints that see no point yet with those of the given neighbours: candidates along the
// epipolar line by descriptor, accepted with enough parallax, in front of both cameras, small reprojection
// error and a distance that agrees with the pyramid levels (Mur-Artal et al. 2015, section VI-C). Returns the
// new points.
std::vector<MapPointId> TriangulatePoints(const MappingCamera& camera, KeyFrameId keyframe,
                                          const std::vector<KeyFrameId>& neighbours, Map* map);

}  // namespace semmap
