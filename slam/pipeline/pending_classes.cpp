#include "slam/pipeline/pending_classes.h"

namespace semmap {

bool PendingClasses::Fill(FrameFeatures* features) {
  const std::shared_ptr<const Segmentation> segmentation = segmentation_.Wait(max_wait_);
  if (segmentation == nullptr) return false;
  const auto class_at = [&segmentation](double x, double y) {
    return segmentation->At(static_cast<float>(x), static_cast<float>(y));
  };
  ClassifyKeypoints(*rule_, pixels_, class_at, &features->keypoints);
  return true;
}

}  // namespace semmap
