#pragma once

#include <atomic>
#include <unordered_map>

#include "slam/pipeline/map_window.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// Bundle adjustment of a whole map that goes on changing: the map is copied, the copy is adjusted (for
// seconds, on another thread), and the result is merged into what the map has become. Solve and Apply are
// called once each, in this order, from any thread; Apply from the map's owner.
class FullBundle {
 public:
  FullBundle(const LoopConfig& config, const ProjectionModel& model, const Map& map);

  // `stop` becoming true ends it early; its result so far can still be applied, or dropped.
  BundleSummary Solve(const std::atomic<bool>* stop);

  // Keyframes that came after the copy move with their parents, points with their reference keyframes
  // (Mur-Artal and Tardos 2017, section III-D).
  void Apply(Map* map) const;

 private:
  LoopConfig config_;
  MapWindow window_;
};

}  // namespace semmap
