#include "slam/pipeline/keypoint_classes.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

constexpr uint8_t kBuilding = 1;
constexpr uint8_t kSky = 13;

// A house left of column 50, sky right of it.
cv::Mat HouseAndSky() {
  cv::Mat classes(60, 100, CV_8UC1, cv::Scalar(kSky));
  classes.colRange(0, 50).setTo(kBuilding);
  return classes;
}

Keypoint Classify(const SemanticsConfig& config, float x, uint8_t octave, const cv::Mat& confidence = {}) {
  const cv::Mat classes = HouseAndSky();
  std::vector<Keypoint> keypoints(1);
  keypoints[0].octave = octave;
  const KeypointClassRule rule(config, ScalePyramidInfo(3, 2.0));
  ClassifyKeypoints(
      rule, {{x, 30}}, [&](double u, double v) { return LookUpMask(classes, confidence, u, v); }, &keypoints);
  return keypoints[0];
}

TEST(KeypointClasses, TheNearestPixelCountsAlsoBeyondTheRim) {
  const cv::Mat classes = HouseAndSky();
  EXPECT_EQ(LookUpMask(classes, {}, 49.4, 30).semantic_class, kBuilding);
  EXPECT_EQ(LookUpMask(classes, {}, 49.6, 30).semantic_class, kSky);
  EXPECT_EQ(LookUpMask(classes, {}, -9, 300).semantic_class, kBuilding);
  EXPECT_EQ(LookUpMask(classes, {}, 1000, -7).semantic_class, kSky);
  EXPECT_EQ(LookUpMask(classes, {}, 1000, -7).confidence, 255);
}

TEST(KeypointClasses, ACornerOnTheRimOfTheSkyBelongsToWhatStandsBeforeIt) {
  SemanticsConfig config;
  config.sky_rim_px = 3;
  EXPECT_EQ(Classify(config, 52, 0).semantic_class, kBuilding);
  EXPECT_EQ(Classify(config, 55, 0).semantic_class, kSky);
  EXPECT_EQ(Classify(config, 55, 1).semantic_class, kBuilding);
  config.sky_rim_px = 0;
  EXPECT_EQ(Classify(config, 52, 0).semantic_class, kSky);
}

TEST(KeypointClasses, ACornerWhereTwoClassesMeetKnowsBoth) {
  SemanticsConfig config;
  config.sky_rim_px = 0;
  config.class_rim_px = 2;
  EXPECT_EQ(Classify(config, 48.6F, 0).semantic_class, kBuilding);
  EXPECT_EQ(Classify(config, 48.6F, 0).class_beside, kSky);
  EXPECT_EQ(Classify(config, 51, 0).class_beside, kBuilding);
  EXPECT_EQ(Classify(config, 46, 0).class_beside, kUnknownClass);
  EXPECT_EQ(Classify(config, 46, 1).class_beside, kSky);
  config.class_rim_px = 0;
  EXPECT_EQ(Classify(config, 48.6F, 0).class_beside, kUnknownClass);
}

TEST(KeypointClasses, UnsureOnesHaveNoClass) {
  SemanticsConfig config;
  config.min_confidence = 0.5;
  EXPECT_EQ(Classify(config, 20, 0, cv::Mat(60, 100, CV_8UC1, cv::Scalar(100))).semantic_class,
            kUnknownClass);
  const Keypoint sure = Classify(config, 20, 0, cv::Mat(60, 100, CV_8UC1, cv::Scalar(200)));
  EXPECT_EQ(sure.semantic_class, kBuilding);
  EXPECT_EQ(sure.class_confidence, 200);
}

}  // namespace
}  // namespace semmap
