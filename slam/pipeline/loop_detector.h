#pragma once

#include <unordered_set>
#include <vector>

#include "slam/map/map.h"
#include "slam/pipeline/place_memory.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// Looks for places that a new keyframe shows again: keyframes outside of its covisible surroundings that look
// at least as much like it as its own neighbours do, confirmed by several keyframes in a row whose candidates
// lie in one covisible group (Mur-Artal et al. 2015, section VII-A). Not thread-safe.
class LoopDetector {
 public:
  explicit LoopDetector(const LoopConfig& config) : config_(config) {}

  // Confirmed candidates, the most similar first. `current` must be in `places`.
  std::vector<KeyFrameId> Detect(const Map& map, const PlaceMemory& places, KeyFrameId current);
  // After a loop was closed, or the map forgotten.
  void Reset() { chains_.clear(); }

 private:
  using Group = std::unordered_set<KeyFrameId, IdHash>;
  // A group of keyframes that the last `length` keyframes in a row resembled.
  struct Chain {
    Group group;
    int length = 0;
  };

  std::vector<PlaceMatch> FindSimilar(const Map& map, const PlaceMemory& places, KeyFrameId current) const;

  LoopConfig config_;
  std::vector<Chain> chains_;
};

}  // namespace semmap
