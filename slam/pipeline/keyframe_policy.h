#pragma once

#include "slam/geometry/camera.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// What the decision for a keyframe rests on.
struct KeyFrameEvidence {
  SensorType sensor = SensorType::kMono;
  int inliers = 0;
  // Established points of the reference keyframe: what a frame at its place would track.
  int reference_points = 0;
  int map_keyframes = 0;
  double seconds_since_keyframe = 0;
  // The mapper has nothing to do; if not, it may still have room in its queue.
  bool mapper_idle = true;
  bool mapper_accepts = true;
  // Depth sensors: keypoints near enough for a reliable depth that do and do not see a point.
  int close_tracked = 0;
  int close_untracked = 0;
};

// A frame is kept when tracking gets weak against the reference keyframe, or when new close stereo points are
// needed (Mur-Artal et al. 2015, section V-E; Mur-Artal and Tardos 2017, section III-E). A pure function.
bool IsKeyFrameNeeded(const TrackingConfig& config, const KeyFrameEvidence& evidence);

}  // namespace semmap
