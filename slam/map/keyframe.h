#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "slam/common/ids.h"
#include "slam/common/time.h"
#include "slam/features/feature_grid.h"
#include "slam/features/frame_features.h"
#include "slam/geometry/se3.h"

namespace semmap {

// A kept frame. Its features never change and are shared; pose, observations and neighbours are the mapper's.
struct KeyFrame {
  KeyFrameId id;
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  SE3 camera_from_map;
  std::shared_ptr<const FrameFeatures> features;
  std::shared_ptr<const FeatureGrid> grid;

  // Point that each keypoint sees; none where it sees none.
  std::vector<MapPointId> points;
  // Keyframes that see some of the same points, and how many of them. Kept up to date by Map.
  std::unordered_map<KeyFrameId, int, IdHash> covisible;
  // Spanning tree: the keyframe that shared most points at creation. None for the first.
  KeyFrameId parent;
  // Keyframes of the same place, found by loop closing.
  std::vector<KeyFrameId> loops;

  Eigen::Vector3d Center() const { return camera_from_map.Inverse().translation(); }
};

}  // namespace semmap
