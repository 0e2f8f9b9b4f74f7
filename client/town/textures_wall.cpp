#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"
#include "client/town/textures.h"

namespace semmap::town {
namespace {

// Courses of blocks in `rows` rows of `columns` each, every second one shifted by half a block.
void Courses(int columns, int rows, const cv::Scalar& mortar, const cv::Scalar& tone, double jitter,
             double joint, Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), mortar);
  const double w = static_cast<double>(kTextureSize) / columns;
  const double h = static_cast<double>(kTextureSize) / rows;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const cv::Scalar colour =
          random->Chance(0.12) ? Scaled(Jitter(tone, jitter, random), 0.68) : Jitter(tone, jitter, random);
      const double x = (column + (row % 2 == 1 ? 0.5 : 0.0)) * w;
      const cv::Rect2d block(x + joint / 2, row * h + joint / 2, w - joint, h - joint);
      FillRect(rgb, block, colour);
      if (x + w > kTextureSize) FillRect(rgb, block - cv::Point2d(kTextureSize, 0), colour);
    }
  }
}

void PaintBrick(int variant, Random* random, cv::Mat* rgb) {
  static const cv::Scalar kTones[] = {Rgb(168, 92, 70), Rgb(196, 164, 124), Rgb(130, 88, 76)};
  Courses(12, 36, variant == 1 ? Rgb(150, 140, 124) : Rgb(176, 168, 158), kTones[variant], 0.22, 2.4, random,
          rgb);
  Modulate(rgb, Noise(TextureSize(), {6, 6}, 4, 0.6, random), 0.06);
  Modulate(rgb, Speckle(TextureSize(), 0.9, random), 0.06);
  DrawStreaks(rgb, 14, 0.3, random);
}

void PaintPlaster(int variant, Random* random, cv::Mat* rgb) {
  static const cv::Scalar kTones[] = {Rgb(222, 214, 196), Rgb(214, 208, 204), Rgb(206, 190, 168)};
  *rgb = Filled(TextureSize(), kTones[variant]);
  Modulate(rgb, Noise(TextureSize(), {5, 5}, 5, 0.65, random), 0.06);
  Modulate(rgb, Speckle(TextureSize(), 1.1, random), 0.035 + 0.02 * variant);
  const cv::Mat patches = Noise(TextureSize(), {7, 7}, 5, 0.6, random);
  Blend(rgb, 0.35 * SmoothMask(patches, 1.1, 1.3), Rgb(150, 140, 128));
  DrawCracks(rgb, 6, 180, Rgb(120, 112, 102), 1.2, random);
  DrawStreaks(rgb, 26, 0.35, random);
  DrawSpots(rgb, 90, 1, 4, 0.6, 0.9, random);
}

// Plaster that fell off in places and shows the bricks below.
void PaintBrokenPlaster(Random* random, cv::Mat* rgb) {
  cv::Mat brick;
  PaintBrick(0, random, &brick);
  PaintPlaster(2, random, rgb);
  const cv::Mat shape = Noise(TextureSize(), {4, 4}, 6, 0.6, random);
  const cv::Mat hole = SmoothMask(shape, 0.8, 0.88);
  const cv::Mat rim = SmoothMask(shape, 0.68, 0.78);
  Blend(rgb, 0.6 * rim, Rgb(140, 128, 112));
  cv::Mat wide;
  cv::merge(std::vector<cv::Mat>(3, hole), wide);
  *rgb = *rgb + wide.mul(brick - *rgb);
}

void PaintAshlar(int variant, Random* random, cv::Mat* rgb) {
  Courses(variant == 0 ? 6 : 9, variant == 0 ? 14 : 18, Rgb(110, 104, 96),
          variant == 0 ? Rgb(190, 180, 160) : Rgb(160, 156, 152), 0.13, 3.0, random, rgb);
  Modulate(rgb, Noise(TextureSize(), {9, 9}, 5, 0.7, random), 0.07);
  Modulate(rgb, Speckle(TextureSize(), 1.0, random), 0.05);
  DrawStreaks(rgb, 22, 0.35, random);
  DrawSpots(rgb, 120, 1, 4, 0.6, 0.95, random);
}

void PaintConcrete(int variant, Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), variant == 0 ? Rgb(162, 160, 154) : Rgb(138, 138, 136));
  Modulate(rgb, Noise(TextureSize(), {5, 5}, 6, 0.62, random), 0.09);
  Modulate(rgb, Speckle(TextureSize(), 0.9, random), 0.05);
  for (int i = 0; i < 4; ++i) {
    const double at = i * kTextureSize / 4.0;
    FillRect(rgb, {0, at, kTextureSize, 2.5}, Rgb(96, 95, 92));
    if (variant == 1) FillRect(rgb, {at, 0, 2.5, kTextureSize}, Rgb(90, 89, 86));
  }
  DrawSpots(rgb, 160, 1, 4, 0.5, 0.9, random);
  DrawCracks(rgb, 7, 200, Rgb(92, 90, 88), 1.3, random);
  DrawStreaks(rgb, 36, 0.45, random);
}

void PaintPanels(Random* random, cv::Mat* rgb) {
  Courses(4, 8, Rgb(70, 72, 76), Rgb(178, 184, 190), 0.12, 5.0, random, rgb);
  Modulate(rgb, Noise(TextureSize(), {4, 10}, 4, 0.6, random), 0.05);
  DrawStreaks(rgb, 30, 0.25, random);
  DrawSpots(rgb, 120, 1, 2.2, 0.4, 0.8, random);
}

void PaintTiles(Random* random, cv::Mat* rgb) {
  Courses(20, 30, Rgb(120, 116, 110), Rgb(200, 190, 172), 0.26, 1.6, random, rgb);
  Modulate(rgb, Noise(TextureSize(), {5, 5}, 4, 0.6, random), 0.07);
  DrawStreaks(rgb, 18, 0.3, random);
}

// Field stones of random size in mortar.
void PaintRubble(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(104, 98, 90));
  for (int row = 0; row < 17; ++row) {
    for (int column = 0; column < 13; ++column) {
      const cv::Point2d centre(
          (column + (row % 2 == 1 ? 0.5 : 0.0) + random->Uniform(-0.16, 0.16)) * kTextureSize / 13,
          (row + 0.5 + random->Uniform(-0.12, 0.12)) * kTextureSize / 17);
      const cv::Size axes(random->Integer(15, 20), random->Integer(11, 15));
      const cv::Scalar tone = Jitter(Rgb(150, 142, 130), 0.3, random);
      const double angle = random->Uniform(-14, 14);
      for (const double wrap : {0.0, -1.0 * kTextureSize}) {
        cv::ellipse(*rgb, cv::Point(centre + cv::Point2d(wrap, 0)), axes, angle, 0, 360, tone, cv::FILLED,
                    cv::LINE_AA);
      }
    }
  }
  Modulate(rgb, Noise(TextureSize(), {26, 26}, 4, 0.7, random), 0.09);
  Modulate(rgb, Speckle(TextureSize(), 0.9, random), 0.07);
}

void PaintWood(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(150, 112, 74));
  for (int plank = 0; plank < 16; ++plank) {
    FillRect(rgb, {plank * 32.0 + 1, 0, 30, kTextureSize}, Jitter(Rgb(156, 116, 78), 0.24, random));
  }
  Modulate(rgb, Noise(TextureSize(), {90, 4}, 3, 0.6, random), 0.12);
  Modulate(rgb, Noise(TextureSize(), {6, 6}, 3, 0.6, random), 0.08);
  for (int plank = 0; plank <= 16; ++plank)
    FillRect(rgb, {plank * 32.0 - 1, 0, 2.5, kTextureSize}, Rgb(58, 42, 28));
  DrawSpots(rgb, 70, 2, 5, 0.35, 0.6, random);  // knots and nails
}

void PaintMetal(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(176, 180, 184));
  Modulate(rgb, Noise(TextureSize(), {6, 6}, 5, 0.6, random), 0.07);
  const cv::Mat rust = Noise(TextureSize(), {9, 9}, 5, 0.7, random);
  Blend(rgb, 0.8 * SmoothMask(rust, 1.4, 1.8), Rgb(122, 76, 44));
  DrawSpots(rgb, 200, 1, 3, 0.5, 0.9, random);
  DrawStreaks(rgb, 20, 0.3, random);
}

void PaintCorrugated(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(156, 162, 168));
  for (int x = 0; x < kTextureSize; ++x) {
    const double tone = 0.78 + 0.3 * std::sin(x * 2 * CV_PI / 16.0);
    rgb->col(x) *= tone;
  }
  const cv::Mat rust = Noise(TextureSize(), {7, 7}, 5, 0.7, random);
  Blend(rgb, 0.8 * SmoothMask(rust, 0.9, 1.4), Rgb(124, 82, 54));
  DrawStreaks(rgb, 40, 0.4, random);
}

void PaintRoof(const cv::Scalar& tone, int columns, int rows, Random* random, cv::Mat* rgb) {
  Courses(columns, rows, Scaled(tone, 0.4), tone, 0.22, 2.6, random, rgb);
  const double h = static_cast<double>(kTextureSize) / rows;
  for (int row = 0; row < rows; ++row) {  // each row throws a shadow on the next
    const cv::Rect shade(0, static_cast<int>(row * h), kTextureSize, 3);
    (*rgb)(shade) *= 0.6;
  }
  Modulate(rgb, Noise(TextureSize(), {6, 6}, 4, 0.6, random), 0.1);
}

void PaintFelt(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(92, 92, 94));
  Modulate(rgb, Noise(TextureSize(), {5, 5}, 5, 0.6, random), 0.14);
  Modulate(rgb, Speckle(TextureSize(), 0.9, random), 0.1);
  for (int i = 0; i < 4; ++i) FillRect(rgb, {0, i * 128.0, kTextureSize, 3}, Rgb(60, 60, 62));
}

}  // namespace

void PaintWall(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* /*alpha*/) {
  Random random(seed, 101, static_cast<uint64_t>(texture));
  const auto index_from = [texture](Texture first) {
    return static_cast<int>(texture) - static_cast<int>(first);
  };
  switch (texture) {
    case Texture::kBrick0:
    case Texture::kBrick1:
    case Texture::kBrick2:
      return PaintBrick(index_from(Texture::kBrick0), &random, rgb);
    case Texture::kPlaster0:
    case Texture::kPlaster1:
    case Texture::kPlaster2:
      return PaintPlaster(index_from(Texture::kPlaster0), &random, rgb);
    case Texture::kPlasterBroken:
      return PaintBrokenPlaster(&random, rgb);
    case Texture::kAshlar0:
    case Texture::kAshlar1:
      return PaintAshlar(index_from(Texture::kAshlar0), &random, rgb);
    case Texture::kConcrete0:
    case Texture::kConcrete1:
      return PaintConcrete(index_from(Texture::kConcrete0), &random, rgb);
    case Texture::kPanels:
      return PaintPanels(&random, rgb);
    case Texture::kTiles:
      return PaintTiles(&random, rgb);
    case Texture::kRubble:
      return PaintRubble(&random, rgb);
    case Texture::kWood:
      return PaintWood(&random, rgb);
    case Texture::kMetal:
      return PaintMetal(&random, rgb);
    case Texture::kCorrugated:
      return PaintCorrugated(&random, rgb);
    case Texture::kRoofTiles:
      return PaintRoof(Rgb(168, 92, 66), 16, 14, &random, rgb);
    case Texture::kSlate:
      return PaintRoof(Rgb(104, 110, 120), 14, 18, &random, rgb);
    default:
      return PaintFelt(&random, rgb);
  }
}

}  // namespace semmap::town
