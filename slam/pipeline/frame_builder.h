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
#include "slam/pipeline/slam_config.h"

namespace semmap {

// What the tracker works on: an image reduced to features, and what it made of them.
struct TrackedFrame {
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  std::shared_ptr<FrameFeatures> features;
  std::shared_ptr<FeatureGrid> grid;
  SE3 camera_from_map;
};

// Turns images into features with undistorted positions, depth and class. Not thread-safe.
class FrameBuilder {
 public:
  FrameBuilder(const SlamConfig& config, const CameraRig& rig);

  // INVALID_ARGUMENT when the images are not what the rig says.
  absl::Status Check(const FrameInput& input) const;
  // Needs a checked input. Fills extract_ms and stereo_ms of `times`.
  TrackedFrame Build(const FrameInput& input, StageTimes* times);

  const CameraRig& rig() const { return rig_; }
  const ImageBounds& bounds() const { return bounds_; }
  const ScalePyramidInfo& scale_info() const { return left_extractor_.scale_info(); }
  // Zero baseline for monocular rigs.
  const ProjectionModel& model() const { return model_; }

 private:
  void AddClasses(const FrameInput& input, FrameFeatures* features) const;
  void Undistort(FrameFeatures* features);
  void AddDepth(const FrameInput& input, FrameFeatures* features);

  CameraRig rig_;
  bool use_classes_;
  uint8_t min_confidence_;  // 255 = certain
  double sky_rim_px_;
  ImageBounds bounds_;
  ProjectionModel model_;
  OrbExtractor left_extractor_;
  std::optional<OrbExtractor> right_extractor_;
  std::optional<StereoMatcher> stereo_matcher_;
  FrameFeatures right_features_;
  std::vector<cv::Point2f> raw_pixels_;
};

// What mapping and relocalization need to know of the frames' camera.
MappingCamera MakeMappingCamera(const SlamConfig& config, const FrameBuilder& builder);

}  // namespace semmap
