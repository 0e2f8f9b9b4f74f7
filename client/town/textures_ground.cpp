#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"
#include "client/town/textures.h"

namespace semmap::town {
namespace {

void PaintAsphalt(int variant, Random* random, cv::Mat* rgb) {
  static const cv::Scalar kTones[] = {Rgb(112, 111, 112), Rgb(96, 97, 101), Rgb(128, 124, 119)};
  *rgb = Filled(TextureSize(), kTones[variant % 3]);
  Modulate(rgb, Noise(TextureSize(), {5, 5}, 4, 0.6, random), 0.07);
  Modulate(rgb, Speckle(TextureSize(), 0.8, random), 0.10);  // the aggregate
  DrawSpots(rgb, 900, 1, 2.6, 0.65, 1.45, random);
  DrawSpots(rgb, 60, 3, 9, 0.75, 1.2, random);
  DrawCracks(rgb, 5 + 3 * variant, 260, Rgb(45, 44, 44), 1.4, random);
  if (variant == 1) DrawCracks(rgb, 2, 420, Rgb(30, 30, 32), 5, random);  // sealed with tar
}

// Rows of slabs, each with its own tone, separated by joints.
void PaintSlabs(int columns, int rows, const cv::Scalar& tone, double jitter, bool staggered, Random* random,
                cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Scaled(tone, 0.5));
  const double w = static_cast<double>(kTextureSize) / columns;
  const double h = static_cast<double>(kTextureSize) / rows;
  for (int row = 0; row < rows; ++row) {
    const double shift = staggered && row % 2 == 1 ? w / 2 : 0;
    for (int column = 0; column < columns; ++column) {
      const cv::Scalar colour = Jitter(tone, jitter, random);
      const double x = column * w + shift;
      FillRect(rgb, {x + 1.2, row * h + 1.2, w - 2.4, h - 2.4}, colour);
      if (x + w > kTextureSize)
        FillRect(rgb, {x - kTextureSize + 1.2, row * h + 1.2, w - 2.4, h - 2.4}, colour);
    }
  }
}

void PaintPaving(int variant, Random* random, cv::Mat* rgb) {
  if (variant == 0) {
    PaintSlabs(6, 9, Rgb(158, 152, 144), 0.16, true, random, rgb);
  } else {
    PaintSlabs(9, 9, Rgb(148, 138, 130), 0.2, false, random, rgb);
  }
  Modulate(rgb, Noise(TextureSize(), {7, 7}, 4, 0.6, random), 0.07);
  Modulate(rgb, Speckle(TextureSize(), 0.8, random), 0.07);
  DrawSpots(rgb, 140, 2, 5, 0.45, 0.8, random);  // chewing gum and dirt
  DrawCracks(rgb, 6, 120, Rgb(70, 66, 62), 1.2, random);
}

void PaintSetts(Random* random, cv::Mat* rgb) {
  PaintSlabs(20, 24, Rgb(118, 114, 112), 0.3, true, random, rgb);
  Modulate(rgb, Speckle(TextureSize(), 1.0, random), 0.08);
  Modulate(rgb, Noise(TextureSize(), {6, 6}, 3, 0.6, random), 0.08);
}

void PaintRoadPaint(Random* random, cv::Mat* rgb) {
  *rgb = Filled(TextureSize(), Rgb(226, 226, 220));
  Modulate(rgb, Noise(TextureSize(), {9, 9}, 4, 0.6, random), 0.05);
  const cv::Mat worn = Noise(TextureSize(), {28, 28}, 4, 0.75, random);
  Blend(rgb, SmoothMask(worn, 1.2, 1.6), Rgb(118, 117, 116));
  Modulate(rgb, Speckle(TextureSize(), 0.9, random), 0.05);
  DrawCracks(rgb, 14, 120, Rgb(92, 91, 90), 1.5, random);
}

}  // namespace

void PaintGround(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* /*alpha*/) {
  Random random(seed, 100, static_cast<uint64_t>(texture));
  switch (texture) {
    case Texture::kAsphalt0:
      return PaintAsphalt(0, &random, rgb);
    case Texture::kAsphalt1:
      return PaintAsphalt(1, &random, rgb);
    case Texture::kAsphalt2:
      return PaintAsphalt(2, &random, rgb);
    case Texture::kPavingSlabs0:
      return PaintPaving(0, &random, rgb);
    case Texture::kPavingSlabs1:
      return PaintPaving(1, &random, rgb);
    case Texture::kSetts:
      return PaintSetts(&random, rgb);
    default:
      return PaintRoadPaint(&random, rgb);
  }
}

}  // namespace semmap::town
