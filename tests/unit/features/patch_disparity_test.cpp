#include "slam/features/patch_disparity.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "slam/features/padded_image.h"
#include "tests/unit/features/test_images.h"

namespace semmap {
namespace {

cv::Mat Padded(const cv::Mat& image) {
  cv::Mat padded = MakePaddedImage(image.size());
  image.copyTo(padded);
  return padded;
}

// What lies at column x of `image` lies at x - disparity of the result.
cv::Mat Shifted(const cv::Mat& image, double disparity) {
  const cv::Matx23d transform(1, 0, -disparity, 0, 1, 0);
  cv::Mat shifted;
  cv::warpAffine(image, shifted, transform, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
  return Padded(shifted);
}

TEST(PatchDisparity, FindsShiftsToAFractionOfAPixelWithoutDrawingThemToWholeOnes) {
  const cv::Mat left = Padded(test::TexturedImage({400, 200}, 71));
  for (const double disparity : {20.0, 20.15, 20.3, 20.5, 20.7, 20.85}) {
    const cv::Mat right = Shifted(left, disparity);
    std::vector<double> errors;
    for (int y = 20; y < 180; y += 7) {
      for (int x = 50; x < 350; x += 7) {
        const auto match = FindPatchInRow(left, right, x, y, x - 22);
        if (match) errors.push_back(x - double{match->right_x} - disparity);
      }
    }
    ASSERT_GT(errors.size(), 500u);
    std::sort(errors.begin(), errors.end());
    EXPECT_NEAR(errors[errors.size() / 2], 0, 0.065) << disparity;
    EXPECT_LT(errors[errors.size() * 9 / 10] - errors[errors.size() / 10], 0.2) << disparity;
  }
}

TEST(PatchDisparity, ADifferenceOfBrightnessDoesNotMoveTheResult) {
  const cv::Mat left = Padded(test::TexturedImage({200, 100}, 72));
  const cv::Mat right = Shifted(left, 10.4);
  cv::Mat brighter;
  right.convertTo(brighter, CV_8U, 1, 6);
  brighter = Padded(brighter);
  int compared = 0;
  for (int x = 40; x < 160; x += 3) {
    const auto same = FindPatchInRow(left, right, x, 50, x - 10);
    const auto lit = FindPatchInRow(left, brighter, x, 50, x - 10);
    if (!same || !lit) continue;
    ++compared;
    EXPECT_NEAR(same->right_x, lit->right_x, 0.15) << x;
  }
  EXPECT_GT(compared, 10);
}

TEST(PatchDisparity, NothingAtTheEndOfTheSearchOrBeyondTheImage) {
  const cv::Mat left = Padded(test::TexturedImage({200, 100}, 73));
  const cv::Mat right = Shifted(left, 10);
  ASSERT_TRUE(FindPatchInRow(left, right, 100, 50, 90));
  EXPECT_NEAR(FindPatchInRow(left, right, 100, 50, 90)->right_x, 90, 0.05);
  EXPECT_FALSE(FindPatchInRow(left, right, 100, 50, 90 + kPatchSearch));
  for (const auto& [x, y, guess] : {std::tuple{5, 50, 50},
                                    {194, 50, 150},
                                    {100, 4, 90},
                                    {100, 95, 90},
                                    {100, 50, 10},
                                    {100, 50, 189},
                                    {-50, 50, 50},
                                    {100, 5000, 90},
                                    {100, 50, -7}}) {
    EXPECT_FALSE(FindPatchInRow(left, right, x, y, guess)) << x << " " << y << " " << guess;
  }
}

TEST(PatchDisparity, NothingWhereOnePlaceIsAsGoodAsAnother) {
  const cv::Mat flat = Padded(cv::Mat(60, 100, CV_8UC1, cv::Scalar(90)));
  EXPECT_FALSE(FindPatchInRow(flat, flat, 50, 30, 50));
  // A horizontal edge with noise.
  cv::Mat noise(60, 100, CV_8UC1);
  cv::RNG random(5);
  const auto edge = [&] {
    random.fill(noise, cv::RNG::UNIFORM, 0, 6);
    cv::Mat image = noise.clone();
    image.rowRange(30, 60) += 150;
    return Padded(image);
  };
  const cv::Mat left = edge();
  const cv::Mat right = edge();
  for (int x = 30; x < 70; ++x) EXPECT_FALSE(FindPatchInRow(left, right, x, 30, x)) << x;
}

}  // namespace
}  // namespace semmap
