// What the features are worth on recorded street images: matches that agree with the epipolar geometry of a
// rectified stereo camera, depth, and coverage. Skipped where the recording is missing.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "slam/features/descriptor_search.h"
#include "slam/features/orb_extractor.h"
#include "slam/features/stereo_matcher.h"

namespace semmap {
namespace {

constexpr double kFocal = 707.0912;
constexpr double kBaseline = 379.8145 / 707.0912;
constexpr int kFrames[] = {0, 17, 34, 50};

class RecordedImages : public testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("SEMMAP_SHARED");
    folder_ = std::string(shared != nullptr ? shared : SEMMAP_SOURCE_DIR "/../shared") +
              "/data/sequences/kitti06_stereo51/";
    if (Image("image_0", 0).empty()) GTEST_SKIP() << "no recorded images in " << folder_;
  }

  cv::Mat Image(const std::string& camera, int frame) const {
    const std::string number = std::to_string(frame);
    return cv::imread(folder_ + camera + "/" + std::string(6 - number.size(), '0') + number + ".png",
                      cv::IMREAD_GRAYSCALE);
  }

 private:
  std::string folder_;
};

// Matches between the left and the right image that are nearest to each other, and how many of them lie on
// the same row (to two pixels of their level) with a possible disparity.
struct RowAgreement {
  int mutual = 0;
  int agreeing = 0;
  std::vector<double> row_errors;  // of the agreeing, in pixels of their level

  void Add(const FrameFeatures& left, const FrameFeatures& right) {
    for (size_t i = 0; i < left.size(); ++i) {
      const int j = FindNearestTwo(left.descriptors[i], right.descriptors).index;
      if (FindNearestTwo(right.descriptors[j], left.descriptors).index != static_cast<int>(i)) continue;
      ++mutual;
      const Keypoint& p = left.keypoints[i];
      const Keypoint& q = right.keypoints[j];
      const double error = std::abs(p.y - q.y) / std::pow(1.2, std::max(p.octave, q.octave));
      if (error > 2 || p.x - q.x < 0 || p.x - q.x > 200) continue;
      ++agreeing;
      row_errors.push_back(error);
    }
  }
  double MedianRowError() {
    const auto middle = row_errors.begin() + static_cast<ptrdiff_t>(row_errors.size() / 2);
    std::nth_element(row_errors.begin(), middle, row_errors.end());
    return *middle;
  }
};

TEST_F(RecordedImages, TrainedPatternMatchesMoreThanARandomOne) {
  OrbExtractor trained(OrbConfig{});
  OrbExtractor random(OrbConfig{}, GaussianPattern(1));
  const auto agreement = [&](OrbExtractor* extractor) {
    RowAgreement result;
    for (const int frame : kFrames) {
      FrameFeatures left;
      FrameFeatures right;
      extractor->Extract(Image("image_0", frame), &left);
      extractor->Extract(Image("image_1", frame), &right);
      result.Add(left, right);
    }
    return result;
  };
  RowAgreement with_trained = agreement(&trained);
  const RowAgreement with_random = agreement(&random);
  EXPECT_GT(with_trained.agreeing, 1.05 * with_random.agreeing);
  EXPECT_GT(with_trained.agreeing, 0.75 * with_trained.mutual);
  // Whole pixels would give a quarter at best.
  EXPECT_LT(with_trained.MedianRowError(), 0.22);
  RecordProperty("agreeing_trained", with_trained.agreeing);
  RecordProperty("agreeing_random", with_random.agreeing);
}

TEST_F(RecordedImages, HalfOfTheKeypointsHaveStereoDepthAndCoverTheImage) {
  OrbExtractor left(OrbConfig{});
  OrbExtractor right(OrbConfig{});
  StereoConfig all;
  all.max_depth_in_baselines = 800;
  StereoMatcher matcher(all, kFocal, kBaseline);
  int keypoints = 0;
  int with_depth = 0;
  double occupied = 0;
  for (const int frame : kFrames) {
    const cv::Mat image = Image("image_0", frame);
    FrameFeatures left_features;
    FrameFeatures right_features;
    left.Extract(image, &left_features);
    right.Extract(Image("image_1", frame), &right_features);
    matcher.Match(left, right, right_features, &left_features);
    std::set<std::pair<int, int>> cells;
    for (const Keypoint& keypoint : left_features.keypoints) {
      ++keypoints;
      with_depth += keypoint.HasDepth() ? 1 : 0;
      cells.insert({static_cast<int>(keypoint.x) / 32, static_cast<int>(keypoint.y) / 32});
      // The camera is 1.7 m above the road and no vehicle is ahead within 3 m.
      if (keypoint.HasDepth()) {
        EXPECT_GT(keypoint.depth, 2.5);
      }
    }
    occupied +=
        static_cast<double>(cells.size()) / ((image.cols / 32) * (image.rows / 32)) / std::size(kFrames);
  }
  EXPECT_GT(with_depth, 0.45 * keypoints);
  EXPECT_GT(occupied, 0.6);
  RecordProperty("with_depth", with_depth);
}

}  // namespace
}  // namespace semmap
