#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"
#include "client/town/textures.h"

namespace semmap::town {
namespace {

void PaintGrass(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(92, 112, 56));
  for (int i = 0; i < 9000; ++i) {
    const cv::Point root(random->Below(kTextureSize), random->Below(kTextureSize));
    const cv::Point tip = root + cv::Point(random->Integer(-4, 4), random->Integer(-9, -3));
    cv::line(*rgb, root, tip,
             Hsv(random->Uniform(65, 105), random->Uniform(0.35, 0.6), random->Uniform(0.25, 0.6)), 1,
             cv::LINE_AA);
  }
  Modulate(rgb, Noise(TextureSize(), {6, 6}, 4, 0.6, random), 0.12);
  const cv::Mat bare = Noise(TextureSize(), {5, 5}, 5, 0.6, random);
  Blend(rgb, 0.7 * SmoothMask(bare, 1.3, 1.7), Rgb(128, 108, 80));
  DrawSpots(rgb, 120, 1, 3, 1.2, 2.2, random);  // daisies
}

void PaintSoil(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(124, 100, 76));
  Modulate(rgb, Noise(TextureSize(), {8, 8}, 6, 0.7, random), 0.16);
  DrawSpots(rgb, 500, 1, 5, 0.6, 1.5, random);
}

void PaintStones(double radius_low, double radius_high, int count, const cv::Scalar& tone, Random* random,
                 cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Scaled(tone, 0.4));
  for (int i = 0; i < count; ++i) {
    const cv::Point at(random->Below(kTextureSize), random->Below(kTextureSize));
    const double radius = random->Uniform(radius_low, radius_high);
    cv::ellipse(*rgb, at, cv::Size(static_cast<int>(radius), std::max(1, static_cast<int>(radius * 0.7))),
                random->Uniform(0, 180), 0, 360, Jitter(tone, 0.35, random), cv::FILLED, cv::LINE_AA);
  }
  Modulate(rgb, Speckle(TextureSize(), 0.8, random), 0.07);
}

void PaintWater(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(70, 92, 98));
  Modulate(rgb, Noise(TextureSize(), {6, 14}, 5, 0.62, random), 0.2);
  const cv::Mat glints = Noise(TextureSize(), {14, 44}, 3, 0.6, random);
  Blend(rgb, 0.6 * SmoothMask(glints, 1.4, 2.0), Rgb(196, 208, 212));
}

void PaintBark(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(112, 96, 80));
  Modulate(rgb, Noise(TextureSize(), {30, 5}, 4, 0.7, random), 0.26);
  Modulate(rgb, Noise(TextureSize(), {8, 8}, 4, 0.7, random), 0.12);
  DrawSpots(rgb, 60, 3, 9, 0.5, 1.3, random);
}

cv::Scalar LeafColour(double hue, Random* random) {
  return Hsv(hue + random->Uniform(-14, 14), random->Uniform(0.4, 0.7), random->Uniform(0.22, 0.66));
}

void DrawLeaf(cv::Mat* rgb, cv::Mat* alpha, cv::Point at, double size, const cv::Scalar& tone,
              Random* random) {
  const double angle = random->Uniform(0, 360);
  const cv::Size axes(std::max(2, static_cast<int>(size)), std::max(1, static_cast<int>(size * 0.5)));
  cv::ellipse(*rgb, at, axes, angle, 0, 360, tone, cv::FILLED, cv::LINE_AA);
  if (alpha != nullptr) cv::ellipse(*alpha, at, axes, angle, 0, 360, 1.0, cv::FILLED, cv::LINE_AA);
  const cv::Point2d vein(std::cos(angle * CV_PI / 180) * size * 0.8,
                         std::sin(angle * CV_PI / 180) * size * 0.8);
  cv::line(*rgb, at - cv::Point(vein), at + cv::Point(vein), Scaled(tone, 1.3), 1, cv::LINE_AA);
}

// A spray of leaves, dense in the middle and ragged at the rim.
void PaintLeaves(int variant, Random* random, cv::Mat* rgb, cv::Mat* alpha) {
  static const double kHues[] = {92, 76, 112, 100};
  *rgb = Filled(TextureSize(), Hsv(kHues[variant], 0.55, 0.26));
  alpha->setTo(0);
  for (int i = 0; i < 620; ++i) {
    const double radius = 225 * std::sqrt(random->Uniform());
    const double angle = random->Uniform(0, 2 * CV_PI);
    const cv::Point at(static_cast<int>(256 + radius * std::cos(angle)),
                       static_cast<int>(256 + radius * std::sin(angle)));
    // Leaves painted later lie on top and in the light.
    const cv::Scalar tone = Scaled(LeafColour(kHues[variant], random), 0.55 + 0.75 * i / 620.0);
    DrawLeaf(rgb, alpha, at, random->Uniform(10, 21), tone, random);
  }
}

void PaintHedge(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Hsv(100, 0.55, 0.14));
  for (int i = 0; i < 3200; ++i) {
    const cv::Scalar tone = Scaled(LeafColour(98, random), 0.4 + 0.8 * i / 3200.0);
    DrawLeaf(rgb, nullptr, {random->Below(kTextureSize), random->Below(kTextureSize)}, random->Uniform(5, 11),
             tone, random);
  }
}

void PaintSky(Random* random, cv::Mat* rgb) {
  for (int y = 0; y < kTextureSize; ++y) {
    const double t = static_cast<double>(y) / kTextureSize;  // top of the sky first
    rgb->row(y).setTo(Rgb(96, 140, 200) * (1 - t) + Rgb(196, 210, 224) * t);
  }
  cv::Mat clouds = Noise(TextureSize(), {4, 7}, 7, 0.55, random);
  Blend(rgb, 0.85 * SmoothMask(clouds, 0.2, 1.4), Rgb(238, 240, 243));
  const cv::Mat under = Noise(TextureSize(), {5, 9}, 6, 0.55, random);
  Blend(rgb, 0.35 * SmoothMask(clouds, 0.7, 1.6).mul(SmoothMask(under, 0.0, 1.2)), Rgb(150, 156, 166));
}

}  // namespace

void PaintNature(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha) {
  Random random(seed, 104, static_cast<uint64_t>(texture));
  switch (texture) {
    case Texture::kGrass:
      return PaintGrass(&random, rgb);
    case Texture::kSoil:
      return PaintSoil(&random, rgb);
    case Texture::kGravel:
      return PaintStones(2, 6, 7000, Rgb(158, 148, 132), &random, rgb);
    case Texture::kBallast:
      return PaintStones(5, 12, 3600, Rgb(122, 112, 104), &random, rgb);
    case Texture::kWater:
      return PaintWater(&random, rgb);
    case Texture::kBark:
      return PaintBark(&random, rgb);
    case Texture::kHedge:
      return PaintHedge(&random, rgb);
    case Texture::kLeaves0:
    case Texture::kLeaves1:
    case Texture::kLeaves2:
    case Texture::kBush:
      return PaintLeaves(static_cast<int>(texture) - static_cast<int>(Texture::kLeaves0), &random, rgb,
                         alpha);
    default:
      return PaintSky(&random, rgb);
  }
}

}  // namespace semmap::town
