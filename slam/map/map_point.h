#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "slam/common/ids.h"
#include "slam/features/descriptor.h"

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

  // In how many frames the point should have been seen, and was.
  uint32_t visible = 1;
  uint32_t found = 1;
  // Value of the map's keyframe counter when the point was made; young points are on probation.
  uint64_t born_at_keyframe = 0;
};

}  // namespace semmap
