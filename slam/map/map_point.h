#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "slam/common/ids.h"
#include "slam/features/descriptor.h"
#include "slam/semantics/class_votes.h"

namespace semmap {

// "Keypoint `keypoint` of keyframe `keyframe` sees the point."
struct Observation {
  KeyFrameId keyframe;
  uint32_t keypoint = 0;
};

struct MapPoint {
  MapPointId id;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  // In order of arrival; at most one for each keyframe.
  std::vector<Observation> observations;
  KeyFrameId reference_keyframe;

  // Derived from the observations by UpdateAppearance.
  Descriptor descriptor;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float min_distance = 0;
  float max_distance = 0;

  // One for each keypoint that saw the point. Keyframes that were culled as redundant keep theirs; it goes
  // with an observation that turned out to be wrong. Class and activity follow from it, see PointClassPolicy.
  ClassVotes votes;
  uint8_t semantic_class = kUnknownClass;
  // An inactive point is remembered, and observed to see whether its class changes; nothing is located by it,
  // and it ties no keyframes together.
  bool active = true;

  // In how many frames the point should have been seen, and was.
  uint32_t visible = 1;
  uint32_t found = 1;
};

}  // namespace semmap
