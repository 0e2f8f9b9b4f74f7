#include "client/town/textures.h"

#include <set>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace semmap::town {
namespace {

double Difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

TEST(Textures, DependOnTheSeedAlone) {
  for (const Texture texture :
       {Texture::kBrick0, Texture::kShops1, Texture::kLeaves0, Texture::kCar2, Texture::kFaces}) {
    EXPECT_EQ(Difference(PaintTexture(texture, 7), PaintTexture(texture, 7)), 0);
    EXPECT_GT(Difference(PaintTexture(texture, 7), PaintTexture(texture, 8)), 1);
  }
}

TEST(Textures, EveryLayerIsPainted) {
  for (int i = 0; i < kTextureCount; ++i) {
    const cv::Mat layer = PaintTexture(static_cast<Texture>(i), 1);
    ASSERT_EQ(layer.type(), CV_8UC4);
    ASSERT_EQ(layer.size(), cv::Size(kTextureSize, kTextureSize));
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(layer, mean, deviation);
    EXPECT_GT(deviation[0] + deviation[1] + deviation[2], 6) << "layer " << i << " is nearly plain";
  }
}

TEST(Textures, RepeatingOnesMeetAtTheirBorders) {
  for (const Texture texture :
       {Texture::kAsphalt0, Texture::kBrick0, Texture::kPlaster0, Texture::kConcrete0}) {
    cv::Mat grey;
    cv::cvtColor(PaintTexture(texture, 1), grey, cv::COLOR_RGBA2GRAY);
    grey.convertTo(grey, CV_32F);
    const double across_border = cv::norm(grey.col(0), grey.col(kTextureSize - 1), cv::NORM_L1);
    const double inside = cv::norm(grey.col(200), grey.col(201), cv::NORM_L1);
    EXPECT_LT(across_border, 2.5 * inside + kTextureSize) << static_cast<int>(texture);
  }
}

TEST(Textures, LeavesAndFencesHaveHoles) {
  for (const Texture texture : {Texture::kLeaves0, Texture::kFenceBars, Texture::kTrafficSigns}) {
    cv::Mat alpha;
    cv::extractChannel(PaintTexture(texture, 1), alpha, 3);
    const double solid =
        static_cast<double>(cv::countNonZero(alpha > 128)) / static_cast<double>(alpha.total());
    EXPECT_GT(solid, 0.1);
    EXPECT_LT(solid, 0.95);
  }
}

TEST(Grime, StaysAroundNeutral) {
  const cv::Mat grime = PaintGrime(1);
  const cv::Scalar mean = cv::mean(grime);
  EXPECT_NEAR(mean[0], 128, 30);
  EXPECT_NEAR(mean[1], 128, 30);
}

}  // namespace
}  // namespace semmap::town
