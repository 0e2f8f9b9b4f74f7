#pragma once

#include <vector>

#include "slam/map/map.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// Points on probation: a new point must be found in more than a quarter of the frames that should see it, and
// be seen by three keyframes (two with depth) once two more keyframes have come; otherwise it is removed.
// Points that passed leave `young` (Mur-Artal et al. 2015, section VI-B).
void CullYoungPoints(bool has_depth, std::vector<MapPointId>* young, Map* map);

// Removes keyframes around `keyframe` of whose points nearly all are seen by three others at the same or a
// finer scale (section VI-E). Depth farther than `close_depth_m` does not count (0: no limit). Returns those
// that were removed.
std::vector<KeyFrameId> CullKeyFrames(const MappingConfig& config, double close_depth_m, KeyFrameId keyframe,
                                      Map* map);

}  // namespace semmap
