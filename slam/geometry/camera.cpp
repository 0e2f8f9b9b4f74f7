#include "slam/geometry/camera.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap {
namespace {

constexpr int kMinImageSide = 16;
constexpr int kMaxImageSide = 16384;
// A focal length of a hundred image sides is a field of view of half a degree: no vehicle's camera.
constexpr double kMaxFocalInSides = 100;
constexpr double kMaxDistortion = 1000;
constexpr double kMaxBaselineM = 100;
constexpr double kMaxDepthUnits = 1e7;
constexpr double kMaxFramesPerSecond = 1000;

// Undistortion inverts a polynomial by fixed-point iteration; OpenCV's default of 5 rounds leaves up to a
// pixel in the corners of a wide lens.
const cv::TermCriteria kUndistortCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 1e-4);

// Pixels near 90 degrees off the axis go to infinity; the box of a fisheye ends this many image sides
// outside.
constexpr float kMaxBoundsMargin = 2.0F;
constexpr int kBorderSamples = 32;

absl::Status CheckRange(const char* field, double value, double low, double high) {
  if (value >= low && value <= high) return absl::OkStatus();  // false for not-a-number
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", value, ", must be between ", low, " and ", high));
}

// As CheckRange, but `low` itself is refused.
absl::Status CheckAbove(const char* field, double value, double low, double high) {
  if (value > low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", value, ", must be above ", low, " and at most ", high));
}

absl::Status ValidateDistortion(const CameraIntrinsics& camera) {
  switch (camera.distortion_model) {
    case DistortionModel::kNone:
      return absl::OkStatus();
    case DistortionModel::kRadialTangential:
    case DistortionModel::kEquidistant:
      break;
    default:
      return absl::InvalidArgumentError("camera.distortion_model is unknown");
  }
  for (const double coefficient : camera.distortion) {
    SEMMAP_RETURN_IF_ERROR(CheckRange("camera.distortion", coefficient, -kMaxDistortion, kMaxDistortion));
  }
  return absl::OkStatus();
}

absl::Status ValidateIntrinsics(const CameraIntrinsics& camera) {
  SEMMAP_RETURN_IF_ERROR(CheckRange("camera.width", camera.width, kMinImageSide, kMaxImageSide));
  SEMMAP_RETURN_IF_ERROR(CheckRange("camera.height", camera.height, kMinImageSide, kMaxImageSide));
  const double max_focal = kMaxFocalInSides * std::max(camera.width, camera.height);
  SEMMAP_RETURN_IF_ERROR(CheckAbove("camera.fx", camera.fx, 0, max_focal));
  SEMMAP_RETURN_IF_ERROR(CheckAbove("camera.fy", camera.fy, 0, max_focal));
  SEMMAP_RETURN_IF_ERROR(CheckRange("camera.cx", camera.cx, 0, camera.width - 1));
  SEMMAP_RETURN_IF_ERROR(CheckRange("camera.cy", camera.cy, 0, camera.height - 1));
  return ValidateDistortion(camera);
}

absl::Status ValidateSensor(const CameraRig& rig) {
  switch (rig.sensor) {
    case SensorType::kMono:
      return absl::OkStatus();
    case SensorType::kStereo:
      if (rig.camera.distortion_model != DistortionModel::kNone) {
        return absl::InvalidArgumentError("camera.distortion_model: stereo images must be rectified");
      }
      return CheckAbove("baseline_m", rig.baseline_m, 0, kMaxBaselineM);
    case SensorType::kRgbd:
      SEMMAP_RETURN_IF_ERROR(CheckRange("baseline_m", rig.baseline_m, 0, kMaxBaselineM));
      return CheckAbove("depth_units_per_metre", rig.depth_units_per_metre, 0, kMaxDepthUnits);
  }
  return absl::InvalidArgumentError("sensor is unknown");
}

// Points evenly along the border of the image, corners included: the extremes of a distorted image may lie in
// the middle of its sides.
std::vector<Eigen::Vector2f> BorderPixels(const CameraIntrinsics& camera) {
  const auto width = static_cast<float>(camera.width);
  const auto height = static_cast<float>(camera.height);
  std::vector<Eigen::Vector2f> border;
  border.reserve(4 * (kBorderSamples + 1));
  for (int i = 0; i <= kBorderSamples; ++i) {
    const float fraction = static_cast<float>(i) / static_cast<float>(kBorderSamples);
    border.emplace_back(fraction * width, 0.0F);
    border.emplace_back(fraction * width, height);
    border.emplace_back(0.0F, fraction * height);
    border.emplace_back(width, fraction * height);
  }
  return border;
}

}  // namespace

absl::Status ValidateRig(const CameraRig& rig) {
  SEMMAP_RETURN_IF_ERROR(ValidateIntrinsics(rig.camera));
  SEMMAP_RETURN_IF_ERROR(ValidateSensor(rig));
  SEMMAP_RETURN_IF_ERROR(CheckAbove("frames_per_second", rig.frames_per_second, 0, kMaxFramesPerSecond));
  if (!rig.body_from_camera.IsFinite()) return absl::InvalidArgumentError("body_from_camera is not finite");
  return absl::OkStatus();
}

void UndistortPixels(const CameraIntrinsics& camera, std::vector<Eigen::Vector2f>* pixels) {
  if (pixels->empty() || camera.distortion_model == DistortionModel::kNone) return;
  const cv::Matx33d matrix(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  // A view of the vector's own memory: Vector2f and a two-channel float pixel are laid out alike.
  cv::Mat raw(static_cast<int>(pixels->size()), 1, CV_32FC2, pixels->data());
  const auto& k = camera.distortion;
  if (camera.distortion_model == DistortionModel::kEquidistant) {
    const cv::Vec4d coefficients(k[0], k[1], k[2], k[3]);
    cv::fisheye::undistortPoints(raw.clone(), raw, matrix, coefficients, cv::noArray(), matrix);
  } else {
    const cv::Vec<double, 5> coefficients(k[0], k[1], k[2], k[3], k[4]);
    cv::undistortPoints(raw.clone(), raw, matrix, coefficients, cv::noArray(), matrix, kUndistortCriteria);
  }
}

ImageBounds UndistortedBounds(const CameraIntrinsics& camera) {
  const auto width = static_cast<float>(camera.width);
  const auto height = static_cast<float>(camera.height);
  if (camera.distortion_model == DistortionModel::kNone) return {0, 0, width, height};
  std::vector<Eigen::Vector2f> border = BorderPixels(camera);
  UndistortPixels(camera, &border);
  Eigen::Vector2f low(width, height);
  Eigen::Vector2f high(0, 0);
  for (const Eigen::Vector2f& pixel : border) {
    low = low.cwiseMin(pixel);
    high = high.cwiseMax(pixel);
  }
  const Eigen::Vector2f margin = kMaxBoundsMargin * Eigen::Vector2f(width, height);
  low = low.cwiseMax(-margin);
  high = high.cwiseMin(Eigen::Vector2f(width, height) + margin);
  return {low.x(), low.y(), high.x(), high.y()};
}

}  // namespace semmap
