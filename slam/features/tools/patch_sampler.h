#pragma once

#include <cstdint>
#include <random>

#include <opencv2/core/mat.hpp>

#include "slam/features/orb_extractor.h"
#include "slam/features/smoothing.h"
#include "slam/features/tools/pattern_selection.h"

namespace semmap {

// Collects patches around the keypoints that OrbExtractor finds in images, each turned upright by its
// orientation, together with the same patch in a copy of the image that was turned, scaled, shifted, relit
// and made noisy.
class PatchSampler {
 public:
  PatchSampler(int patches_per_image, uint32_t seed);

  // `grey` is CV_8UC1, at least 64 x 64.
  void Add(const cv::Mat& grey);
  const PatchSamples& samples() const { return samples_; }

 private:
  cv::Mat Distort(const cv::Mat& grey, cv::Matx23d* distorted_from_original);
  bool AppendPatch(const OrbExtractor& extractor, const std::vector<cv::Mat>& smoothed,
                   const cv::Point2d& place, int octave, std::vector<std::vector<uint8_t>>* values) const;

  int patches_per_image_;
  std::mt19937 random_;
  OrbExtractor original_;
  OrbExtractor distorted_;
  PatchSamples samples_;
};

}  // namespace semmap
