#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/types.hpp>

#include "absl/time/time.h"
#include "slam/features/frame_features.h"
#include "slam/pipeline/keypoint_classes.h"
#include "slam/semantics/segmentation_queue.h"

namespace semmap {

// Classes on their way to the keypoints of one image.
class PendingClasses {
 public:
  // `pixels`: where the keypoints lie in the image as it was taken.
  PendingClasses(PendingSegmentation segmentation, std::vector<cv::Point2f> pixels,
                 std::shared_ptr<const KeypointClassRule> rule, absl::Duration max_wait)
      : segmentation_(std::move(segmentation)),
        pixels_(std::move(pixels)),
        rule_(std::move(rule)),
        max_wait_(max_wait) {}

  // Not thread-safe. Waits for the segmentation and gives each keypoint its class. False when it does not
  // come within `max_wait`; it may be asked again.
  bool Fill(FrameFeatures* features);

 private:
  PendingSegmentation segmentation_;
  std::vector<cv::Point2f> pixels_;
  std::shared_ptr<const KeypointClassRule> rule_;
  absl::Duration max_wait_;
};

}  // namespace semmap
