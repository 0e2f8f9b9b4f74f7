#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "slam/features/stereo_matcher.h"

namespace semmap {
namespace {

constexpr float kNoDepth = -1;

// Metres at a pixel of the depth image, or kNoDepth.
float DepthAt(const cv::Mat& depth, int x, int y, double units_per_metre) {
  if (depth.type() == CV_16UC1) {
    const uint16_t units = depth.at<uint16_t>(y, x);
    if (units == 0 || units == std::numeric_limits<uint16_t>::max()) return kNoDepth;
    return static_cast<float>(units / units_per_metre);
  }
  const float metres = depth.at<float>(y, x);
  return std::isfinite(metres) && metres > 0 ? metres : kNoDepth;
}

}  // namespace

void AttachDepth(const cv::Mat& depth, double units_per_metre, double focal_times_baseline,
                 const std::vector<cv::Point2f>& raw_pixels, FrameFeatures* features) {
  for (Keypoint& keypoint : features->keypoints) keypoint.right_x = keypoint.depth = kNoDepth;
  const bool readable = depth.type() == CV_32FC1 || (depth.type() == CV_16UC1 && units_per_metre > 0);
  if (!readable) return;
  const size_t count = std::min(raw_pixels.size(), features->size());
  for (size_t i = 0; i < count; ++i) {
    const float x = std::round(raw_pixels[i].x);
    const float y = std::round(raw_pixels[i].y);
    const bool inside =
        x >= 0 && y >= 0 && x < static_cast<float>(depth.cols) && y < static_cast<float>(depth.rows);
    if (!inside) continue;
    const float metres = DepthAt(depth, static_cast<int>(x), static_cast<int>(y), units_per_metre);
    if (metres <= 0) continue;
    Keypoint& keypoint = features->keypoints[i];
    keypoint.depth = metres;
    keypoint.right_x = keypoint.x - static_cast<float>(focal_times_baseline) / metres;
  }
}

}  // namespace semmap
