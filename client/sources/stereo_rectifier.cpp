#include "client/sources/stereo_rectifier.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"

namespace semmap::client {
namespace {

cv::Mat MatrixOf(const CameraIntrinsics& camera) {
  return (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
}

bool IsFisheye(const CameraIntrinsics& camera) {
  return camera.distortion_model == DistortionModel::kEquidistant;
}

cv::Mat DistortionOf(const CameraIntrinsics& camera) {
  const int count = IsFisheye(camera) ? 4 : 5;
  cv::Mat distortion(1, count, CV_64F);
  for (int i = 0; i < count; ++i) distortion.at<double>(i) = camera.distortion[static_cast<size_t>(i)];
  return distortion;
}

struct Rectification {
  cv::Mat rotation_left, rotation_right, projection_left, projection_right;
};

Rectification Rectify(const CameraIntrinsics& left, const CameraIntrinsics& right,
                      const SE3& right_from_left) {
  cv::Mat rotation;
  cv::Mat translation;
  cv::eigen2cv(right_from_left.RotationMatrix(), rotation);
  cv::eigen2cv(right_from_left.translation(), translation);
  const cv::Size size(left.width, left.height);
  Rectification r;
  cv::Mat q;
  if (IsFisheye(left)) {
    cv::fisheye::stereoRectify(MatrixOf(left), DistortionOf(left), MatrixOf(right), DistortionOf(right), size,
                               rotation, translation, r.rotation_left, r.rotation_right, r.projection_left,
                               r.projection_right, q, cv::CALIB_ZERO_DISPARITY);
  } else {
    // Alpha 0: every pixel of the result is seen by the camera.
    cv::stereoRectify(MatrixOf(left), DistortionOf(left), MatrixOf(right), DistortionOf(right), size,
                      rotation, translation, r.rotation_left, r.rotation_right, r.projection_left,
                      r.projection_right, q, cv::CALIB_ZERO_DISPARITY, 0.0);
  }
  return r;
}

}  // namespace

StereoRectifier::RemapTable StereoRectifier::MakeTable(const CameraIntrinsics& raw, const cv::Mat& rotation,
                                                       const cv::Mat& projection) {
  const cv::Size size(raw.width, raw.height);
  RemapTable table;
  if (IsFisheye(raw)) {
    cv::fisheye::initUndistortRectifyMap(MatrixOf(raw), DistortionOf(raw), rotation, projection, size,
                                         CV_16SC2, table.map1, table.map2);
  } else {
    cv::initUndistortRectifyMap(MatrixOf(raw), DistortionOf(raw), rotation, projection, size, CV_16SC2,
                                table.map1, table.map2);
  }
  return table;
}

absl::StatusOr<StereoRectifier> StereoRectifier::Create(const CameraIntrinsics& left,
                                                        const CameraIntrinsics& right,
                                                        const SE3& right_from_left) {
  if (left.width != right.width || left.height != right.height || IsFisheye(left) != IsFisheye(right)) {
    return absl::InvalidArgumentError(
        "the cameras of a stereo pair must have one size and one distortion model");
  }
  try {
    const Rectification r = Rectify(left, right, right_from_left);
    const cv::Mat& projection = r.projection_left;
    StereoRectifier rectifier;
    rectifier.camera_ = {left.width,
                         left.height,
                         projection.at<double>(0, 0),
                         projection.at<double>(1, 1),
                         projection.at<double>(0, 2),
                         projection.at<double>(1, 2),
                         DistortionModel::kNone,
                         {}};
    rectifier.baseline_m_ = -r.projection_right.at<double>(0, 3) / r.projection_right.at<double>(0, 0);
    if (!(rectifier.baseline_m_ > 0)) {
      return absl::InvalidArgumentError(
          "the second camera of a stereo pair must lie to the right of the first");
    }
    Eigen::Matrix3d rectified_from_left;
    cv::cv2eigen(r.rotation_left, rectified_from_left);
    rectifier.left_from_rectified_ =
        SE3(Eigen::Matrix3d(rectified_from_left.transpose()), Eigen::Vector3d::Zero());
    rectifier.left_ = MakeTable(left, r.rotation_left, r.projection_left);
    rectifier.right_ = MakeTable(right, r.rotation_right, r.projection_right);
    return rectifier;
  } catch (const cv::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("the stereo pair cannot be rectified: ", error.what()));
  }
}

absl::StatusOr<cv::Mat> StereoRectifier::Remap(const cv::Mat& image, const RemapTable& table) {
  if (image.size() != table.map1.size() || image.type() != CV_8UC1) {
    return absl::InvalidArgumentError(absl::StrCat("image is ", image.cols, "x", image.rows,
                                                   ", calibrated for ", table.map1.cols, "x",
                                                   table.map1.rows));
  }
  try {
    cv::Mat rectified;
    cv::remap(image, rectified, table.map1, table.map2, cv::INTER_LINEAR);
    return rectified;
  } catch (const cv::Exception& error) {
    return absl::InternalError(error.what());
  }
}

absl::StatusOr<cv::Mat> StereoRectifier::RectifyLeft(const cv::Mat& image) const {
  return Remap(image, left_);
}

absl::StatusOr<cv::Mat> StereoRectifier::RectifyRight(const cv::Mat& image) const {
  return Remap(image, right_);
}

}  // namespace semmap::client
