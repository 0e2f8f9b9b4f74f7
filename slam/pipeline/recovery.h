#pragma once

#include <memory>
#include <vector>

#include "slam/common/ids.h"
#include "slam/pipeline/agreement.h"
#include "slam/pipeline/frame_builder.h"
#include "slam/pipeline/view_localizer.h"

namespace semmap {

// A frame whose place the tracker does not know, or doubts.
struct LostFrame {
  TrackedFrame frame;
  // With the pose it has. Nothing, of a frame that is lost.
  Agreement agreement;

  // Another place must do clearly better than the one that is doubted.
  bool IsBetter(const Agreement& elsewhere) const {
    constexpr double kBetter = 1.5;
    return elsewhere.Trust() > kBetter * agreement.Trust();
  }
};

// Such a frame that was found in the map after all: with its pose, and the points that its
// keypoints see.
struct Recovery {
  TrackedFrame frame;
  std::vector<MapPointId> points;
  // Keyframe around which it was found.
  KeyFrameId reference;
};

// A frame that was found in this view.
std::shared_ptr<const Recovery> MakeRecovery(const TrackedFrame& frame, const LocalMapView& view,
                                             const ViewFix& fix);

}  // namespace semmap
