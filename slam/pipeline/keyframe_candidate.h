#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "slam/common/ids.h"
#include "slam/common/time.h"
#include "slam/features/feature_grid.h"
#include "slam/features/frame_features.h"
#include "slam/geometry/se3.h"
#include "slam/pipeline/pending_classes.h"

namespace semmap {

// How often a point was expected in frames since the last report, and found.
struct PointSightings {
  MapPointId point;
  uint32_t visible = 0;
  uint32_t found = 0;
};

// A frame that the tracker wants to keep, on its way to the mapper.
struct KeyFrameCandidate {
  KeyFrameId id;
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  std::shared_ptr<const FrameFeatures> features;
  std::shared_ptr<const FeatureGrid> grid;
  // Pose relative to a keyframe that the mapper knows: the map may have been adjusted since. For the first
  // keyframe of a map the reference is none and the pose is relative to the map.
  KeyFrameId reference;
  SE3 camera_from_reference;
  // What the tracker matched, for each keypoint.
  std::vector<MapPointId> points;
  std::vector<PointSightings> sightings;
  // Set when the classes of the keypoints are still to come.
  std::shared_ptr<PendingClasses> pending_classes;
};

// Two frames and the points seen in both, from monocular initialization. The first frame is the map's origin.
struct InitialPair {
  KeyFrameCandidate first;
  KeyFrameCandidate second;
  struct Point {
    Eigen::Vector3d position_in_map;
    uint32_t keypoint_in_first = 0;
    uint32_t keypoint_in_second = 0;
  };
  std::vector<Point> points;
};

}  // namespace semmap
