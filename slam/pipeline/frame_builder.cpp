#include "slam/pipeline/frame_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

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

absl::Status CheckImage(const char* name, const cv::Mat& image, const CameraIntrinsics& camera,
                        bool type_ok) {
  if (image.cols != camera.width || image.rows != camera.height) {
    return absl::InvalidArgumentError(absl::StrCat(name, " is ", image.cols, "x", image.rows,
                                                   ", the rig says ", camera.width, "x", camera.height));
  }
  if (!type_ok) return absl::InvalidArgumentError(absl::StrCat(name, " has the wrong pixel type"));
  return absl::OkStatus();
}

constexpr auto kSky = static_cast<uint8_t>(SemanticClass::kSky);

cv::Point NearestPixel(const cv::Mat& image, double x, double y) {
  return {std::clamp(static_cast<int>(std::floor(x + 0.5)), 0, image.cols - 1),
          std::clamp(static_cast<int>(std::floor(y + 0.5)), 0, image.rows - 1)};
}

// A pixel that is not sky at half the radius around the keypoint, or at all of it.
std::optional<cv::Point> BesideTheSky(const cv::Mat& classes, const Keypoint& keypoint, double radius) {
  constexpr int kDirections = 8;
  for (const double distance : {0.5 * radius, radius}) {
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2 * std::numbers::pi * i / kDirections;
      const cv::Point pixel = NearestPixel(classes, keypoint.x + distance * std::cos(angle),
                                           keypoint.y + distance * std::sin(angle));
      if (classes.at<uint8_t>(pixel) != kSky) return pixel;
    }
  }
  return std::nullopt;
}

}  // namespace

FrameBuilder::FrameBuilder(const SlamConfig& config, const CameraRig& rig)
    : rig_(WithDefaults(rig)),
      use_classes_(config.semantics.enabled),
      min_confidence_(static_cast<uint8_t>(std::lround(255 * config.semantics.min_confidence))),
      sky_rim_px_(config.semantics.sky_rim_px),
      bounds_(UndistortedBounds(rig_.camera)),
      model_(MakeModel(rig_)),
      left_extractor_(config.orb) {
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
  return status;
}

TrackedFrame FrameBuilder::Build(const FrameInput& input, StageTimes* times) {
  Stopwatch stopwatch;
  TrackedFrame frame;
  frame.sequence = input.sequence;
  frame.timestamp = input.timestamp;
  frame.features = std::make_shared<FrameFeatures>();
  left_extractor_.Extract(input.image, frame.features.get());
  if (right_extractor_) right_extractor_->Extract(input.right, &right_features_);
  times->extract_ms = stopwatch.LapMs();
  if (use_classes_ && !input.class_mask.empty()) AddClasses(input, frame.features.get());
  AddDepth(input, frame.features.get());
  frame.grid = std::make_shared<FeatureGrid>(bounds_, frame.features->keypoints);
  times->stereo_ms = stopwatch.LapMs();
  return frame;
}

void FrameBuilder::AddClasses(const FrameInput& input, FrameFeatures* features) const {
  for (Keypoint& keypoint : features->keypoints) {
    cv::Point pixel = NearestPixel(input.class_mask, keypoint.x, keypoint.y);
    if (sky_rim_px_ > 0 && input.class_mask.at<uint8_t>(pixel) == kSky) {
      const double radius = sky_rim_px_ * scale_info().scales[keypoint.octave];
      pixel = BesideTheSky(input.class_mask, keypoint, radius).value_or(pixel);
    }
    if (!input.class_confidence.empty())
      keypoint.class_confidence = input.class_confidence.at<uint8_t>(pixel);
    if (keypoint.class_confidence >= min_confidence_)
      keypoint.semantic_class = input.class_mask.at<uint8_t>(pixel);
  }
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
  raw_pixels_.clear();
  for (const Keypoint& keypoint : features->keypoints) raw_pixels_.emplace_back(keypoint.x, keypoint.y);
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
