#include "slam/features/steered_brief.h"

#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

ptrdiff_t Step(const cv::Mat& image) { return static_cast<ptrdiff_t>(image.step[0]); }

TEST(OrbPattern, TestsAreDistinctAndInsideTheirRadius) {
  for (const BriefPattern& pattern : {OrbPattern(), GaussianPattern(7)}) {
    std::set<std::pair<std::pair<int, int>, std::pair<int, int>>> seen;
    for (const BriefTest& test : pattern) {
      EXPECT_LE(test.x1 * test.x1 + test.y1 * test.y1, kBriefRadius * kBriefRadius);
      EXPECT_LE(test.x2 * test.x2 + test.y2 * test.y2, kBriefRadius * kBriefRadius);
      EXPECT_TRUE(test.x1 != test.x2 || test.y1 != test.y2);
      seen.insert({{test.x1, test.y1}, {test.x2, test.y2}});
    }
    EXPECT_EQ(seen.size(), 256u);
  }
}

TEST(SteeredBrief, UprightDescriptorIsThePatternItself) {
  const cv::Mat image = test::TexturedImage({90, 70}, 41);
  const BriefPattern pattern = GaussianPattern(3);
  const SteeredBrief brief(pattern);
  Descriptor descriptor;
  brief.Compute(image.ptr(33, 40), Step(image), 0, &descriptor);
  for (int bit = 0; bit < 256; ++bit) {
    const BriefTest& test = pattern[bit];
    const bool expected =
        image.at<uint8_t>(33 + test.y1, 40 + test.x1) < image.at<uint8_t>(33 + test.y2, 40 + test.x2);
    EXPECT_EQ(descriptor.words[bit / 64] >> (bit % 64) & 1, expected ? 1u : 0u) << bit;
  }
}

TEST(SteeredBrief, QuarterTurnsOfTheImageChangeNothing) {
  // Offsets rotate to whole pixels at quarter turns, so the bits are the same.
  const cv::Mat image = test::TexturedImage({81, 81}, 42);
  const BriefPattern pattern = GaussianPattern(4);
  Descriptor upright;
  SteeredBrief(pattern).Compute(image.ptr(40, 40), Step(image), 0, &upright);
  cv::Mat turned = image.clone();
  for (int quarter = 1; quarter <= 4; ++quarter) {
    cv::rotate(turned.clone(), turned, cv::ROTATE_90_CLOCKWISE);
    Descriptor descriptor;
    SteeredBrief(pattern).Compute(turned.ptr(40, 40), Step(turned), static_cast<float>(quarter * kTurn / 4),
                                  &descriptor);
    EXPECT_EQ(descriptor, upright) << quarter;
  }
}

TEST(SteeredBrief, StaysWithinItsReachAtEveryAngle) {
  // Pixels beyond the reach differ wildly between the two images.
  cv::Mat dark = cv::Mat::zeros(61, 61, CV_8UC1);
  cv::Mat bright(61, 61, CV_8UC1, cv::Scalar(255));
  const cv::Rect reach(30 - kBriefRadius, 30 - kBriefRadius, 2 * kBriefRadius + 1, 2 * kBriefRadius + 1);
  const cv::Mat patch = test::TexturedImage(reach.size(), 43);
  patch.copyTo(dark(reach));
  patch.copyTo(bright(reach));
  const SteeredBrief brief(OrbPattern());
  for (int i = 0; i <= 360; ++i) {
    Descriptor in_dark;
    Descriptor in_bright;
    brief.Compute(dark.ptr(30, 30), Step(dark), static_cast<float>(i * kTurn / 360), &in_dark);
    brief.Compute(bright.ptr(30, 30), Step(bright), static_cast<float>(i * kTurn / 360), &in_bright);
    EXPECT_EQ(in_dark, in_bright) << i;
  }
}

}  // namespace
}  // namespace semmap
