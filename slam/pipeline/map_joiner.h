#pragma once

#include <atomic>

#include "slam/map/map.h"
#include "slam/optimize/bundle_adjustment.h"
#include "slam/pipeline/map_overlap.h"
#include "slam/pipeline/mapping_camera.h"
#include "slam/pipeline/reprojection_error.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// Makes one map of two that lie side by side in one Map, as FindOverlap takes them, along what they show in
// common. Its methods are called once each, in their order. The target's frame and unit stay: its first
// keyframe is held. Not thread-safe; deterministic.
class MapJoiner {
 public:
  // `with_scale`: the unit of neither map is known, so that both may have drifted in scale. All must outlive
  // the joiner.
  MapJoiner(const SlamConfig& config, const MappingCamera& camera, const MapOverlap& overlap,
            KeyFrameId last_of_target, bool with_scale, Map* map);

  // Puts the source where it belongs, into the target's tree of keyframes, and spreads what the places found
  // contradict each other over both maps (EssentialGraph).
  void Align(const std::atomic<bool>* stop);
  // Joins points that are one thing in both maps, by which keyframes of both become covisible; returns how
  // many. False from `visit` ends it early.
  int Fuse(const StepVisitor& visit);
  // Bundle adjustment of the whole.
  BundleSummary Adjust(const std::atomic<bool>* stop);

  // Of the points that keyframes of both maps see.
  ReprojectionError MeasureSeam() const;

 private:
  void MoveSource();
  bool IsOfTarget(KeyFrameId id) const { return id <= last_of_target_; }

  const SlamConfig& config_;
  const MappingCamera& camera_;
  const MapOverlap& overlap_;
  const KeyFrameId last_of_target_;
  const bool with_scale_;
  Map* const map_;
};

}  // namespace semmap
