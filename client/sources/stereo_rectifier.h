#pragma once

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "slam/geometry/camera.h"

namespace semmap::client {

// Turns the raw images of two calibrated cameras into a rectified pair (cv::stereoRectify, or its fisheye
// version for equidistant cameras). Immutable after Create, thread-safe.
class StereoRectifier {
 public:
  // INVALID_ARGUMENT when the models or sizes of the cameras differ, or the right one does not lie to the
  // right.
  static absl::StatusOr<StereoRectifier> Create(const CameraIntrinsics& left, const CameraIntrinsics& right,
                                                const SE3& right_from_left);

  const CameraIntrinsics& camera() const { return camera_; }
  double baseline_m() const { return baseline_m_; }
  // The rectified left camera is the raw one turned on the spot.
  const SE3& left_from_rectified() const { return left_from_rectified_; }

  // CV_8UC1 of the raw size; INVALID_ARGUMENT for another.
  absl::StatusOr<cv::Mat> RectifyLeft(const cv::Mat& image) const;
  absl::StatusOr<cv::Mat> RectifyRight(const cv::Mat& image) const;

 private:
  struct RemapTable {
    cv::Mat map1;
    cv::Mat map2;
  };

  static RemapTable MakeTable(const CameraIntrinsics& raw, const cv::Mat& rotation,
                              const cv::Mat& projection);
  static absl::StatusOr<cv::Mat> Remap(const cv::Mat& image, const RemapTable& table);

  CameraIntrinsics camera_;
  double baseline_m_ = 0;
  SE3 left_from_rectified_;
  RemapTable left_;
  RemapTable right_;
};

}  // namespace semmap::client
