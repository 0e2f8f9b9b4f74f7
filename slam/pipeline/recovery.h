#pragma once

#include <vector>

#include "slam/common/ids.h"
#include "slam/pipeline/agreement.h"
#include "slam/pipeline/frame_builder.h"

namespace semmap {

// A frame whose place the tracker does not know, or doubts.
struct LostFrame {
  TrackedFrame frame;
  // With the pose it has; another place must do clearly better. Nothing, of a frame that is lost.
  Agreement agreement;
};

// Such a frame that was found in the map after all: with its pose, and the points that its
// keypoints see.
struct Recovery {
  TrackedFrame frame;
  std::vector<MapPointId> points;
  // Keyframe around which it was found.
  KeyFrameId reference;
};

}  // namespace semmap
