#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "slam/features/feature_grid.h"
#include "slam/features/orb_extractor.h"
#include "slam/features/stereo_matcher.h"
#include "slam/geometry/camera.h"
#include "slam/optimize/observation.h"
#include "slam/pipeline/frame.h"
#include "slam/pipeline/mapping_camera.h"
#include "slam/pipeline/pending_classes.h"
#include "slam/pipeline/slam_config.h"

namespace semmap {

// What the tracker works on: an image reduced to features, and what it made of them.
struct TrackedFrame {
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  std::shared_ptr<FrameFeatures> features;
  std::shared_ptr<FeatureGrid> grid;
  SE3 camera_from_map;
  bool is_classified = false;
};

// Turns images into features with undistorted positions, depth and class. Not thread-safe.
class FrameBuilder {
 public:
  // Without `segmentation` (or if it is off), only frames that bring a mask have classes.
  FrameBuilder(const SlamConfig& config, const CameraRig& rig,
               std::shared_ptr<SegmentationQueue> segmentation);

  // INVALID_ARGUMENT when the images are not what the rig says.
  absl::Status Check(const FrameInput& input) const;
  // Needs a checked input. With `classify` the image is segmented while features are extracted, unless the
  // frame brings a mask. Fills extract_ms, stereo_ms and classify_ms of `times`.
  TrackedFrame Build(const FrameInput& input, bool classify, StageTimes* times);
  // The classes of `input`, which was built last, for somebody who can wait for them: those that did not come
  // in time, or asked for only now. Null when nobody segments.
  std::shared_ptr<PendingClasses> ClassifyLater(const FrameInput& input);

  bool can_segment() const { return segmentation_ != nullptr; }
  const CameraRig& rig() const { return rig_; }
  const ImageBounds& bounds() const { return bounds_; }
  const ScalePyramidInfo& scale_info() const { return left_extractor_.scale_info(); }
  // Zero baseline for monocular rigs.
  const ProjectionModel& model() const { return model_; }

 private:
  void AddClasses(const FrameInput& input, FrameFeatures* features) const;
  PendingSegmentation Segment(const FrameInput& input);
  bool TakeClasses(PendingSegmentation segmentation, FrameFeatures* features);
  void Undistort(FrameFeatures* features);
  void AddDepth(const FrameInput& input, FrameFeatures* features);

  CameraRig rig_;
  bool use_classes_;
  absl::Duration max_wait_;
  std::shared_ptr<SegmentationQueue> segmentation_;
  // Of the frame built last, when they did not come in time.
  std::shared_ptr<PendingClasses> late_classes_;
  ImageBounds bounds_;
  ProjectionModel model_;
  OrbExtractor left_extractor_;
  std::shared_ptr<const KeypointClassRule> class_rule_;
  std::optional<OrbExtractor> right_extractor_;
  std::optional<StereoMatcher> stereo_matcher_;
  FrameFeatures right_features_;
  // Where the keypoints of the frame built last lie in its image.
  std::vector<cv::Point2f> raw_pixels_;
};

// What mapping and relocalization need to know of the frames' camera.
MappingCamera MakeMappingCamera(const SlamConfig& config, const FrameBuilder& builder);

}  // namespace semmap
