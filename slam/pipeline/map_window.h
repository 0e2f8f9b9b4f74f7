#pragma once

#include <unordered_map>
#include <vector>

#include "slam/map/map.h"
#include "slam/optimize/bundle_adjustment.h"

namespace semmap {

// Part of a map as a bundle problem, with what the problem's indices stand for. Filled from a map, solved
// without it (on any thread), and written back: at once for a local window, later and to a map that has grown
// meanwhile for the whole. A value.
class MapWindow {
 public:
  explicit MapWindow(const ProjectionModel& model) { problem_.model = model; }
  // All of the map; its first keyframe, which has no parent, is fixed.
  static MapWindow Whole(const ProjectionModel& model, const Map& map);

  // --- filling; all of one map
  void AddCamera(const Map& map, KeyFrameId id, bool fixed);
  // Its active points.
  void AddPointsOf(const Map& map, KeyFrameId id);
  // The keyframes outside that see most of the window's points, held fixed.
  void AddRim(const Map& map, size_t limit);
  // If no camera is fixed, fixes the oldest. One camera is enough: the scale of a monocular window is free
  // then, but the solver's damping keeps it, and two fixed cameras would keep the error of their own distance
  // for ever.
  void FixOne();
  // All that the window's cameras see of its points; comes last.
  void AddObservations(const Map& map);

  BundleSummary Solve(const BundleOptions& options) { return AdjustBundle(options, &problem_); }

  // Poses, points and, removed from the map, the outliers among the observations. What the map no longer has
  // is passed over. Inactive points keep their place in the frame of their reference keyframe.
  void WriteBack(Map* map) const;

  const std::vector<KeyFrameId>& cameras() const { return cameras_; }
  bool HasCamera(KeyFrameId id) const { return camera_index_.contains(id); }
  bool HasPoint(MapPointId id) const { return point_index_.contains(id); }

 private:
  BundleProblem problem_;
  std::vector<KeyFrameId> cameras_;
  std::vector<MapPointId> points_;
  std::unordered_map<KeyFrameId, int, IdHash> camera_index_;
  std::unordered_map<MapPointId, int, IdHash> point_index_;
};

}  // namespace semmap
