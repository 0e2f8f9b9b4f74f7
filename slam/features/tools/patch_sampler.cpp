#include "slam/features/tools/patch_sampler.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "slam/features/padded_image.h"
#include "slam/features/patch_orientation.h"

namespace semmap {
namespace {

constexpr int kMargin = kBriefRadius + 1;
// Strength of the distortions: degrees, ratio, grey levels (standard deviations or half ranges).
constexpr double kMaxTurnDegrees = 25;
constexpr double kMaxScaleChange = 0.18;
constexpr double kMaxShear = 0.12;
constexpr double kMaxContrastChange = 0.25;
constexpr double kNoise = 4;

std::vector<cv::Mat> SmoothLevels(const std::vector<cv::Mat>& levels) {
  Smoother smoother;
  std::vector<cv::Mat> smoothed;
  for (const cv::Mat& level : levels) {
    smoothed.push_back(MakePaddedImage(level.size()));
    if (std::min(level.cols, level.rows) > Smoother::kRadius) smoother.Smooth(level, &smoothed.back());
  }
  return smoothed;
}

}  // namespace

PatchSampler::PatchSampler(int patches_per_image, uint32_t seed)
    : patches_per_image_(patches_per_image), random_(seed), original_(OrbConfig{}), distorted_(OrbConfig{}) {
  for (int y = -kBriefRadius; y <= kBriefRadius; ++y) {
    for (int x = -kBriefRadius; x <= kBriefRadius; ++x) {
      if (x * x + y * y > kBriefRadius * kBriefRadius) continue;
      samples_.places.push_back({static_cast<int8_t>(x), static_cast<int8_t>(y)});
    }
  }
  samples_.original.resize(samples_.places.size());
  samples_.distorted.resize(samples_.places.size());
}

cv::Mat PatchSampler::Distort(const cv::Mat& grey, cv::Matx23d* distorted_from_original) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const cv::Point2f centre(static_cast<float>(grey.cols) / 2, static_cast<float>(grey.rows) / 2);
  const double scale = std::exp(kMaxScaleChange * uniform(random_));
  cv::Matx23d transform = cv::getRotationMatrix2D(centre, kMaxTurnDegrees * uniform(random_), scale);
  transform(0, 1) += kMaxShear * uniform(random_);
  transform(0, 2) += uniform(random_);
  transform(1, 2) += uniform(random_);
  cv::Mat distorted;
  cv::warpAffine(grey, distorted, transform, grey.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
  distorted.convertTo(distorted, CV_16S, 1 + kMaxContrastChange * uniform(random_), 10 * uniform(random_));
  cv::Mat noise(grey.size(), CV_16S);
  cv::RNG(random_()).fill(noise, cv::RNG::NORMAL, 0, kNoise);
  distorted += noise;
  distorted.convertTo(distorted, CV_8U);
  *distorted_from_original = transform;
  return distorted;
}

// Appends the smoothed intensities around `place` (full resolution) if the patch fits into its level.
bool PatchSampler::AppendPatch(const OrbExtractor& extractor, const std::vector<cv::Mat>& smoothed,
                               const cv::Point2d& place, int octave,
                               std::vector<std::vector<uint8_t>>* values) const {
  const cv::Mat& level = extractor.pyramid()[octave];
  const double scale = static_cast<double>(level.cols) / extractor.pyramid()[0].cols;
  const int x = static_cast<int>(std::floor((place.x + 0.5) * scale));
  const int y = static_cast<int>(std::floor((place.y + 0.5) * scale));
  if (x < kMargin || y < kMargin || x >= level.cols - kMargin || y >= level.rows - kMargin) return false;
  const float angle = IntensityCentroidAngle(level.ptr(y, x), static_cast<ptrdiff_t>(level.step[0]));
  const double cosine = std::cos(angle);
  const double sine = std::sin(angle);
  for (size_t i = 0; i < samples_.places.size(); ++i) {
    const auto& offset = samples_.places[i];
    const auto dx = static_cast<int>(std::lround(cosine * offset.x - sine * offset.y));
    const auto dy = static_cast<int>(std::lround(sine * offset.x + cosine * offset.y));
    (*values)[i].push_back(smoothed[octave].at<uint8_t>(y + dy, x + dx));
  }
  return true;
}

void PatchSampler::Add(const cv::Mat& grey) {
  cv::Matx23d distorted_from_original;
  const cv::Mat copy = Distort(grey, &distorted_from_original);
  FrameFeatures features;
  FrameFeatures unused;
  original_.Extract(grey, &features);
  distorted_.Extract(copy, &unused);
  const auto smoothed = SmoothLevels(original_.pyramid());
  const auto smoothed_copy = SmoothLevels(distorted_.pyramid());
  std::shuffle(features.keypoints.begin(), features.keypoints.end(), random_);
  int added = 0;
  for (const Keypoint& keypoint : features.keypoints) {
    if (added == patches_per_image_) break;
    const cv::Point2d moved = distorted_from_original * cv::Vec3d(keypoint.x, keypoint.y, 1);
    if (!AppendPatch(distorted_, smoothed_copy, moved, keypoint.octave, &samples_.distorted)) continue;
    if (AppendPatch(original_, smoothed, {keypoint.x, keypoint.y}, keypoint.octave, &samples_.original)) {
      ++added;
    } else {
      for (auto& values : samples_.distorted) values.pop_back();
    }
  }
}

}  // namespace semmap
