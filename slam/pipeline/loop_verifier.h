#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "slam/map/map.h"
#include "slam/pipeline/mapping_camera.h"
#include "slam/pipeline/place_memory.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// Two keyframes, far apart along the drive, that show one place.
struct Loop {
  KeyFrameId old;
  KeyFrameId current;
  // The current keyframe as seen from the old one. Its scale tells how many units of the map around `old` one
  // unit around `current` is; 1 where depth is measured.
  Sim3 old_from_current;
  // Points of the map around `old`, with the keypoints of `current` that see them.
  std::vector<std::pair<MapPointId, uint32_t>> seen;
  // Points that agree, of the current image in the old surroundings and the other way round.
  int inliers = 0;
  int reverse_inliers = 0;
};

// Decides by geometry whether both keyframes show one place: each image is located in the surroundings of the
// other by guided search, both poses must have enough inliers and must be each other's inverse. The scale of
// a monocular loop is the median ratio of the depths that both sides give to the points they share.
std::optional<Loop> VerifyLoop(const LoopConfig& config, uint32_t seed, const MappingCamera& camera,
                               const PlaceMemory& places, const Map& map, KeyFrameId old, KeyFrameId current);

}  // namespace semmap
