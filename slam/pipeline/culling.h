#pragma once

#include <cstdint>
#include <vector>

#include "slam/map/map.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// Points on probation, of one vehicle: time is counted in its own keyframes, since those of another may be
// elsewhere.
class YoungPoints {
 public:
  void OnKeyFrame() { ++keyframes_; }
  void Add(const std::vector<MapPointId>& created);
  void Clear() { points_.clear(); }

  // A new point must be found in more than a quarter of the frames that should see it, and be seen by three
  // keyframes (two with depth) once two more keyframes have come; otherwise it is removed from the map.
  // Points that passed are young no more (Mur-Artal et al. 2015, section VI-B).
  void Cull(bool has_depth, Map* map);

 private:
  struct Newborn {
    MapPointId id;
    uint64_t born_at_keyframe = 0;
  };
  uint64_t keyframes_ = 0;
  std::vector<Newborn> points_;
};

// A point that so many other keyframes see at the same or a finer scale is not missed where it is left out.
constexpr int kEnoughObservers = 3;
// How many keyframes other than `self`, which sees the point in `octave`, do so; at most kEnoughObservers.
int CountOtherObservers(const MapPoint& point, KeyFrameId self, int octave, const Map& map);

// Removes keyframes around `keyframe` of whose points nearly all are seen by three others at the same or a
// finer scale (section VI-E). Depth farther than `close_depth_m` does not count (0: no limit). Returns those
// that were removed.
std::vector<KeyFrameId> CullKeyFrames(const MappingConfig& config, double close_depth_m, KeyFrameId keyframe,
                                      Map* map);

}  // namespace semmap
