#pragma once

#include <cstdint>
#include <optional>

#include <opencv2/core/mat.hpp>

#include "slam/common/time.h"
#include "slam/geometry/se3.h"
#include "slam/pipeline/localization_failure.h"

namespace semmap {

// One input of a session. Pixels are only read during the call that takes the frame, but for those of which a
// segmentation was asked: they must not be overwritten.
struct FrameInput {
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  cv::Mat image;  // CV_8UC1, the left or only image, as large as the rig says
  cv::Mat right;  // stereo: CV_8UC1, rectified
  cv::Mat depth;  // RGB-D: CV_16UC1 in the rig's units, or CV_32FC1 metres
  // Optional: CV_8UC3 BGR, the colours of `image`; without them segmentation sees it in grey.
  cv::Mat colour;
  cv::Mat class_mask;  // optional: CV_8UC1, ids of SemanticClass, from the vehicle or a Segmenter
  // With a mask, optional: CV_8UC1, how sure each pixel's class is; 255 = certain, as is all without it.
  cv::Mat class_confidence;
};

enum class TrackingState {
  kInitializing,  // no map yet
  kTracking,
  kLost,
};

// What became of the classes of a frame's keypoints.
enum class ClassState {
  kNotWanted,  // nobody asked
  kKnown,
  kPending,  // the frame is a keyframe, and its classes come while it waits for the mapper
  kMissed,   // they did not come in time
};

// Milliseconds of wall time that each stage of a frame took.
struct StageTimes {
  double extract_ms = 0;
  double stereo_ms = 0;    // stereo matching, or depth look-up
  double classify_ms = 0;  // waiting for the classes of keypoints, after all of the above
  double match_ms = 0;     // guided matching against last frame and local map
  double optimize_ms = 0;  // pose
  double total_ms = 0;     // the whole of Session::Track
};

// The answer for one frame.
struct FrameResult {
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  TrackingState state = TrackingState::kInitializing;
  // Set when state is kTracking.
  std::optional<SE3> map_from_camera;
  // Of the camera pose, tangent (translation, rotation) in the camera frame; metres^2, radians^2.
  Matrix6d covariance = Matrix6d::Zero();
  int inliers = 0;
  // kLost in a map that was stored before: why the frame was not found there, as far as that is known yet.
  LocalizationFailure failure = LocalizationFailure::kNone;
  // The pose is in the frame of the piece that the session maps until it finds itself in the stored map.
  bool in_own_piece = false;
  bool is_keyframe = false;
  ClassState classes = ClassState::kNotWanted;
  uint64_t map_version = 0;
  StageTimes times;
};

}  // namespace semmap
