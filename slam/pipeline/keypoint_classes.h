#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "absl/functional/function_ref.h"
#include "slam/features/frame_features.h"
#include "slam/semantics/segmentation.h"
#include "slam/semantics/semantics_config.h"

namespace semmap {

// How keypoints get their classes from what is known of the pixels around them.
struct KeypointClassRule {
  KeypointClassRule(const SemanticsConfig& config, const ScalePyramidInfo& scale_info);

  uint8_t min_confidence = 0;      // 255 = certain; classes that are less sure are none
  double sky_rim_px = 0;           // see SemanticsConfig
  double class_rim_px = 0;         // likewise
  std::vector<float> level_scale;  // of the pyramid
};

// Class of a pixel of the image, which need not lie in it.
using ClassLookup = absl::FunctionRef<PixelClass(double x, double y)>;

// The nearest pixel of a mask; `confidence` may be empty: all certain.
PixelClass LookUpMask(const cv::Mat& classes, const cv::Mat& confidence, double x, double y);

// `pixels` says where the keypoints lie in the image as it was taken.
void ClassifyKeypoints(const KeypointClassRule& rule, const std::vector<cv::Point2f>& pixels,
                       ClassLookup class_at, std::vector<Keypoint>* keypoints);

}  // namespace semmap
