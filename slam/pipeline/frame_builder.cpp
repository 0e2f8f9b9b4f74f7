#include "slam/pipeline/frame_builder.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/pipeline/stopwatch.h"

namespace semmap {
namespace {

// Virtual baseline of an RGB-D camera; about that of a Kinect's projector.
constexpr double kDefaultDepthBaseline = 0.08;

CameraRig WithDefaults(CameraRig rig) {
  if (rig.sensor == SensorType::kRgbd && rig.baseline_m <= 0) rig.baseline_m = kDefaultDepthBaseline;
  return rig;
}

ProjectionModel MakeModel(const CameraRig& rig) {
  const double baseline = rig.sensor == SensorType::kMono ? 0.0 : rig.baseline_m;
  return {rig.camera.fx, rig.camera.fy, rig.camera.cx, rig.camera.cy, rig.camera.fx * baseline};
}

bool Segments(const SlamConfig& config) {
  return config.semantics.enabled && config.segmentation.mode != SegmentationMode::kOff;
}

absl::Status CheckImage(const char* name, const cv::Mat& image, const CameraIntrinsics& camera,
                        bool type_ok) {
  if (image.cols != camera.width || image.rows != camera.height) {
    return absl::InvalidArgumentError(absl::StrCat(name, " is ", image.cols, "x", image.rows,
                                                   ", the rig says ", camera.width, "x", camera.height));
  }
  if (!type_ok) return absl::InvalidArgumentError(absl::StrCat(name, " has the wrong pixel type"));
  return absl::OkStatus();
}

}  // namespace

FrameBuilder::FrameBuilder(const SlamConfig& config, const CameraRig& rig,
                           std::shared_ptr<SegmentationQueue> segmentation)
    : rig_(WithDefaults(rig)),
      use_classes_(config.semantics.enabled),
      max_wait_(config.deterministic ? absl::InfiniteDuration() : config.segmentation.max_wait()),
      segmentation_(Segments(config) ? std::move(segmentation) : nullptr),
      bounds_(UndistortedBounds(rig_.camera)),
      model_(MakeModel(rig_)),
      left_extractor_(config.orb),
      class_rule_(std::make_shared<const KeypointClassRule>(config.semantics, left_extractor_.scale_info())) {
  if (rig_.sensor != SensorType::kStereo) return;
  right_extractor_.emplace(config.orb);
  stereo_matcher_.emplace(config.stereo, rig_.camera.fx, rig_.baseline_m);
}

absl::Status FrameBuilder::Check(const FrameInput& input) const {
  absl::Status status = CheckImage("image", input.image, rig_.camera, input.image.type() == CV_8UC1);
  if (status.ok() && rig_.sensor == SensorType::kStereo) {
    status = CheckImage("right image", input.right, rig_.camera, input.right.type() == CV_8UC1);
  }
  if (status.ok() && rig_.sensor == SensorType::kRgbd) {
    const int type = input.depth.type();
    status = CheckImage("depth image", input.depth, rig_.camera, type == CV_16UC1 || type == CV_32FC1);
  }
  if (status.ok() && !input.class_mask.empty()) {
    status = CheckImage("class mask", input.class_mask, rig_.camera, input.class_mask.type() == CV_8UC1);
  }
  if (status.ok() && !input.class_confidence.empty()) {
    status = CheckImage("class confidence", input.class_confidence, rig_.camera,
                        input.class_confidence.type() == CV_8UC1);
  }
  if (status.ok() && !input.colour.empty()) {
    const int type = input.colour.type();
    status = CheckImage("colour image", input.colour, rig_.camera, type == CV_8UC3 || type == CV_8UC1);
  }
  return status;
}

TrackedFrame FrameBuilder::Build(const FrameInput& input, bool classify, StageTimes* times) {
  Stopwatch stopwatch;
  late_classes_.reset();
  PendingSegmentation segmentation = classify ? Segment(input) : PendingSegmentation();
  TrackedFrame frame;
  frame.sequence = input.sequence;
  frame.timestamp = input.timestamp;
  frame.features = std::make_shared<FrameFeatures>();
  left_extractor_.Extract(input.image, frame.features.get());
  if (right_extractor_) right_extractor_->Extract(input.right, &right_features_);
  times->extract_ms = stopwatch.LapMs();
  raw_pixels_.clear();
  for (const Keypoint& keypoint : frame.features->keypoints) raw_pixels_.emplace_back(keypoint.x, keypoint.y);
  frame.is_classified = use_classes_ && !input.class_mask.empty();
  if (frame.is_classified) AddClasses(input, frame.features.get());
  AddDepth(input, frame.features.get());
  frame.grid = std::make_shared<FeatureGrid>(bounds_, frame.features->keypoints);
  times->stereo_ms = stopwatch.LapMs();
  if (segmentation) frame.is_classified = TakeClasses(std::move(segmentation), frame.features.get());
  times->classify_ms = stopwatch.LapMs();
  return frame;
}

PendingSegmentation FrameBuilder::Segment(const FrameInput& input) {
  if (segmentation_ == nullptr || !input.class_mask.empty()) return {};
  return segmentation_->Submit(input.colour.empty() ? input.image : input.colour);
}

bool FrameBuilder::TakeClasses(PendingSegmentation segmentation, FrameFeatures* features) {
  auto classes =
      std::make_shared<PendingClasses>(std::move(segmentation), raw_pixels_, class_rule_, max_wait_);
  if (classes->Fill(features)) return true;
  late_classes_ = std::move(classes);
  return false;
}

std::shared_ptr<PendingClasses> FrameBuilder::ClassifyLater(const FrameInput& input) {
  if (late_classes_ != nullptr) return std::move(late_classes_);
  PendingSegmentation segmentation = Segment(input);
  if (!segmentation) return nullptr;
  return std::make_shared<PendingClasses>(std::move(segmentation), raw_pixels_, class_rule_, max_wait_);
}

void FrameBuilder::AddClasses(const FrameInput& input, FrameFeatures* features) const {
  const auto class_at = [&input](double x, double y) {
    return LookUpMask(input.class_mask, input.class_confidence, x, y);
  };
  ClassifyKeypoints(*class_rule_, raw_pixels_, class_at, &features->keypoints);
}

void FrameBuilder::Undistort(FrameFeatures* features) {
  if (rig_.camera.distortion_model == DistortionModel::kNone) return;
  std::vector<Eigen::Vector2f> pixels;
  pixels.reserve(features->size());
  for (const Keypoint& keypoint : features->keypoints) pixels.emplace_back(keypoint.x, keypoint.y);
  UndistortPixels(rig_.camera, &pixels);
  for (size_t i = 0; i < pixels.size(); ++i) {
    features->keypoints[i].x = pixels[i].x();
    features->keypoints[i].y = pixels[i].y();
  }
}

void FrameBuilder::AddDepth(const FrameInput& input, FrameFeatures* features) {
  if (rig_.sensor == SensorType::kStereo) {
    stereo_matcher_->Match(left_extractor_, *right_extractor_, right_features_, features);
    return;
  }
  Undistort(features);
  if (rig_.sensor == SensorType::kRgbd) {
    AttachDepth(input.depth, rig_.depth_units_per_metre, model_.focal_times_baseline, raw_pixels_, features);
  }
}

MappingCamera MakeMappingCamera(const SlamConfig& config, const FrameBuilder& builder) {
  const CameraRig& rig = builder.rig();
  const double near =
      rig.sensor == SensorType::kMono ? 0 : config.tracking.close_depth_in_baselines * rig.baseline_m;
  return {rig, builder.bounds(), builder.model(), near, AssociationRule(config.semantics)};
}

}  // namespace semmap
