#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "slam/features/frame_features.h"
#include "slam/features/orb_extractor.h"

namespace semmap {

struct StereoConfig {
  int max_descriptor_distance = 75;  // bits, accepted before refinement
  // Points further away get no depth. The rectification of real rigs is good to a tenth of a pixel, the same
  // for all points: of a far one's small disparity that is a large part, and it does not average out.
  double max_depth_in_baselines = 35;
  // Where fewer are that near, the nearest so many get theirs all the same.
  int min_depths = 300;

  void Read(ConfigReader& reader);
};

// Fills right_x and depth of the keypoints of a rectified left image: candidates on the same row band by
// descriptor, then sub-pixel disparity from patch correlation, then outliers by correlation score are dropped
// (after Mur-Artal and Tardos, ORB-SLAM2, IEEE TRO 2017, section III-A; patch_disparity.h says how it
// differs). `left` and `right` are the extractors that hold the pyramids of the two images just extracted.
// focal_px * baseline_m / disparity = depth. Keypoints without a match lose what depth they had.
// Deterministic. Not thread-safe (keeps buffers).
class StereoMatcher {
 public:
  StereoMatcher(const StereoConfig& config, double focal_px, double baseline_m);

  void Match(const OrbExtractor& left, const OrbExtractor& right, const FrameFeatures& right_features,
             FrameFeatures* left_features);

 private:
  // A left keypoint with its disparity at full resolution, and how badly the patches agree.
  struct Refined {
    int index = 0;
    int score = 0;
    float disparity = 0;
  };

  void BucketRight(const OrbExtractor& right, const FrameFeatures& right_features);
  int BestCandidate(const Keypoint& keypoint, const Descriptor& descriptor, const ScalePyramidInfo& scales,
                    const FrameFeatures& right_features) const;
  void AcceptRefined(FrameFeatures* left_features);
  // Smallest disparity that gives a depth, of those that `refined_` has up to this score.
  float MinDisparity(int max_score);

  StereoConfig config_;
  double focal_px_;
  double baseline_m_;
  int rows_ = 0;
  // Indices of the right keypoints by octave, then image row, then order of extraction; row_begin_ has a slot
  // for each row of each octave and one more.
  std::vector<int> row_begin_;
  std::vector<int> by_row_;
  std::vector<Refined> refined_;
  std::vector<int> scores_;
  std::vector<float> disparities_;
};

// Fills right_x and depth from a registered depth image (CV_16UC1 in `units_per_metre`, or CV_32FC1 in
// metres). raw_pixels[i], the raw (distorted) coordinates of keypoint i, index the depth image, to the
// nearest pixel. 0, 65535 (16 bit), negative and non-finite mean no depth, as does a place outside the image;
// an image of another type gives none at all.
void AttachDepth(const cv::Mat& depth, double units_per_metre, double focal_times_baseline,
                 const std::vector<cv::Point2f>& raw_pixels, FrameFeatures* features);

}  // namespace semmap
