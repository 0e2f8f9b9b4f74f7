#pragma once

#include <vector>

#include "slam/common/ids.h"
#include "slam/pipeline/frame_builder.h"

namespace semmap {

// A frame of a lost tracker that was found in the map after all: with its pose, and the points that its
// keypoints see.
struct Recovery {
  TrackedFrame frame;
  std::vector<MapPointId> points;
  // Keyframe around which it was found.
  KeyFrameId reference;
};

}  // namespace semmap
