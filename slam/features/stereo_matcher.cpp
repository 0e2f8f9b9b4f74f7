#include "slam/features/stereo_matcher.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "slam/common/config_reader.h"
#include "slam/features/patch_disparity.h"

namespace semmap {
namespace {

// No disparity is good enough beyond.
constexpr double kFarthestInBaselines = 800;
// Corners are found to about a pixel of their level, in either image.
constexpr float kRowTolerance = 2.0F;
// Patches of true matches differ by noise and slant; one that differs by this many medians shows something
// else.
constexpr int kMaxScoreInMedians = 2;
// Nearer than this many baselines there is no common view to speak of.
constexpr double kMinDepthInBaselines = 1.0;

// From full resolution to a level, whose outer edges coincide.
int LevelCoordinate(float full, int full_size, int level_size) {
  const float scale = static_cast<float>(level_size) / static_cast<float>(full_size);
  return static_cast<int>(std::floor((full + 0.5F) * scale));
}

}  // namespace

void StereoConfig::Read(ConfigReader& reader) {
  reader.Number("max_descriptor_distance", &max_descriptor_distance, 1, 256);
  reader.Number("max_depth_in_baselines", &max_depth_in_baselines, 2, kFarthestInBaselines);
  reader.Number("min_depths", &min_depths, 0, 10000);
}

StereoMatcher::StereoMatcher(const StereoConfig& config, double focal_px, double baseline_m)
    : config_(config), focal_px_(focal_px), baseline_m_(baseline_m) {}

void StereoMatcher::BucketRight(const OrbExtractor& right, const FrameFeatures& right_features) {
  rows_ = right.pyramid()[0].rows;
  const auto bucket_of = [&](const Keypoint& keypoint) {
    return keypoint.octave * rows_ + std::clamp(static_cast<int>(keypoint.y), 0, rows_ - 1);
  };
  row_begin_.assign(static_cast<size_t>(rows_) * right.pyramid().size() + 1, 0);
  for (const Keypoint& keypoint : right_features.keypoints) ++row_begin_[bucket_of(keypoint)];
  int end = 0;
  for (int& begin : row_begin_) begin = (end += begin);
  by_row_.resize(end);
  for (size_t i = right_features.size(); i-- > 0;) {
    by_row_[--row_begin_[bucket_of(right_features.keypoints[i])]] = static_cast<int>(i);
  }
}

// The right keypoint in the same rows, of about the same scale and not behind the cameras whose descriptor is
// nearest; -1 if none is near enough.
int StereoMatcher::BestCandidate(const Keypoint& keypoint, const Descriptor& descriptor,
                                 const ScalePyramidInfo& scales, const FrameFeatures& right_features) const {
  const auto max_disparity = static_cast<float>(focal_px_ / kMinDepthInBaselines);
  int best = -1;
  int best_distance = config_.max_descriptor_distance + 1;
  const int first_octave = std::max(0, keypoint.octave - 1);
  const int last_octave = std::min(scales.levels() - 1, keypoint.octave + 1);
  for (int octave = first_octave; octave <= last_octave; ++octave) {
    const float tolerance = kRowTolerance * scales.scales[std::max<int>(octave, keypoint.octave)];
    const int first_row = std::clamp(static_cast<int>(keypoint.y - tolerance), 0, rows_ - 1);
    const int last_row = std::clamp(static_cast<int>(keypoint.y + tolerance), 0, rows_ - 1);
    const int end = row_begin_[octave * rows_ + last_row + 1];
    for (int i = row_begin_[octave * rows_ + first_row]; i < end; ++i) {
      const float disparity = keypoint.x - right_features.keypoints[by_row_[i]].x;
      // A match at infinity may seem to lie a little behind it.
      if (disparity < -tolerance || disparity > max_disparity) continue;
      const int distance = HammingDistance(descriptor, right_features.descriptors[by_row_[i]]);
      if (distance < best_distance) {
        best_distance = distance;
        best = by_row_[i];
      }
    }
  }
  return best;
}

void StereoMatcher::Match(const OrbExtractor& left, const OrbExtractor& right,
                          const FrameFeatures& right_features, FrameFeatures* left_features) {
  for (Keypoint& keypoint : left_features->keypoints) keypoint.right_x = keypoint.depth = -1;
  refined_.clear();
  if (left_features->size() == 0 || right_features.size() == 0) return;
  if (left.pyramid()[0].size() != right.pyramid()[0].size()) return;
  BucketRight(right, right_features);
  const cv::Size full = left.pyramid()[0].size();
  for (size_t i = 0; i < left_features->size(); ++i) {
    const Keypoint& keypoint = left_features->keypoints[i];
    const int match =
        BestCandidate(keypoint, left_features->descriptors[i], left.scale_info(), right_features);
    if (match < 0) continue;
    const cv::Mat& left_level = left.pyramid()[keypoint.octave];
    const int x = LevelCoordinate(keypoint.x, full.width, left_level.cols);
    const int y = LevelCoordinate(keypoint.y, full.height, left_level.rows);
    const int guess = LevelCoordinate(right_features.keypoints[match].x, full.width, left_level.cols);
    const auto found = FindPatchInRow(left_level, right.pyramid()[keypoint.octave], x, y, guess);
    if (!found) continue;
    const float scale = static_cast<float>(full.width) / static_cast<float>(left_level.cols);
    refined_.push_back({static_cast<int>(i), found->score, (static_cast<float>(x) - found->right_x) * scale});
  }
  AcceptRefined(left_features);
}

float StereoMatcher::MinDisparity(int max_score) {
  const auto wanted = static_cast<float>(focal_px_ / config_.max_depth_in_baselines);
  const auto least = static_cast<float>(focal_px_ / kFarthestInBaselines);
  const auto needed = static_cast<size_t>(config_.min_depths);
  disparities_.clear();
  for (const Refined& refined : refined_) {
    if (refined.score <= max_score) disparities_.push_back(refined.disparity);
  }
  if (disparities_.size() <= needed) return least;
  if (needed == 0) return wanted;
  const auto last = disparities_.begin() + static_cast<ptrdiff_t>(needed - 1);
  std::nth_element(disparities_.begin(), last, disparities_.end(), std::greater<>());
  return std::clamp(*last, least, wanted);
}

void StereoMatcher::AcceptRefined(FrameFeatures* left_features) {
  if (refined_.empty()) return;
  scores_.clear();
  for (const Refined& refined : refined_) scores_.push_back(refined.score);
  const auto middle = scores_.begin() + static_cast<ptrdiff_t>(scores_.size() / 2);
  std::nth_element(scores_.begin(), middle, scores_.end());
  const int max_score = kMaxScoreInMedians * *middle;
  const float min_disparity = MinDisparity(max_score);
  const auto max_disparity = static_cast<float>(focal_px_ / kMinDepthInBaselines);
  for (const Refined& refined : refined_) {
    if (refined.score > max_score) continue;
    if (!(refined.disparity >= min_disparity && refined.disparity <= max_disparity)) continue;
    Keypoint& keypoint = left_features->keypoints[refined.index];
    keypoint.right_x = keypoint.x - refined.disparity;
    keypoint.depth = static_cast<float>(focal_px_ * baseline_m_) / refined.disparity;
  }
}

}  // namespace semmap
