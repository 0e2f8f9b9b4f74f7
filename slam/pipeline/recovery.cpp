#include "slam/pipeline/recovery.h"

namespace semmap {

std::shared_ptr<const Recovery> MakeRecovery(const TrackedFrame& frame, const LocalMapView& view,
                                             const ViewFix& fix) {
  auto recovery = std::make_shared<Recovery>();
  recovery->frame = frame;
  recovery->frame.camera_from_map = fix.camera_from_map;
  recovery->reference = view.reference().id;
  recovery->points.assign(frame.features->size(), MapPointId());
  for (size_t i = 0; i < fix.matches.size(); ++i) {
    if (fix.matches[i] >= 0) recovery->points[i] = view.ids[static_cast<size_t>(fix.matches[i])];
  }
  return recovery;
}

}  // namespace semmap
