#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slam/common/fwd.h"
#include "slam/features/frame_features.h"
#include "slam/features/orb_pattern.h"

namespace semmap {

struct OrbConfig {
  int features = 2000;         // keypoints aimed at for an image, 100 to 10000
  int levels = 8;              // pyramid levels, 1 to 12
  double scale_factor = 1.2;   // between levels, 1.05 to 2
  int fast_threshold = 20;     // first choice of FAST threshold, 3 to 100
  int min_fast_threshold = 7;  // used in cells where the first finds nothing, 1 to fast_threshold

  void Read(ConfigReader& reader);
};

// Extracts oriented FAST corners spread evenly over the image on a scale pyramid, with steered BRIEF
// descriptors (Rublee et al. 2011). Keeps its buffers between calls: after the first image of a size nothing
// is allocated that the caller does not own. Not thread-safe; one extractor for each thread. Deterministic.
class OrbExtractor {
 public:
  explicit OrbExtractor(const OrbConfig& config);
  // With another pattern than OrbPattern(), to train and compare patterns; such descriptors do not go with
  // others.
  OrbExtractor(const OrbConfig& config, const BriefPattern& pattern);
  ~OrbExtractor();
  OrbExtractor(OrbExtractor&&) noexcept;
  OrbExtractor& operator=(OrbExtractor&&) noexcept;

  // `grey` is CV_8UC1, 64 x 64 to 16384 x 16384; anything else yields no features. Fills keypoints (x, y in
  // raw image coordinates, angle, octave; no depth) and descriptors; what they held before is lost, their
  // capacity is reused.
  void Extract(const cv::Mat& grey, FrameFeatures* features);

  // The pyramid of the last image, level 0 first; valid until the next Extract. Stereo refinement reads it.
  const std::vector<cv::Mat>& pyramid() const;
  const ScalePyramidInfo& scale_info() const;
  const OrbConfig& config() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace semmap
