#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"
#include "client/town/textures.h"

namespace semmap::town {
namespace {

void Bar(cv::Mat* rgb, cv::Mat* alpha, cv::Rect box, const cv::Scalar& tone) {
  cv::rectangle(*alpha, box, 1.0, cv::FILLED);
  cv::rectangle(*rgb, box, tone, cv::FILLED);
  cv::rectangle(*rgb, cv::Rect(box.x, box.y, std::max(1, std::min(box.width, 4)), box.height),
                Scaled(tone, 0.6), cv::FILLED);
}

void Beam(cv::Mat* rgb, cv::Mat* alpha, cv::Point a, cv::Point b, int width, const cv::Scalar& tone) {
  cv::line(*alpha, a, b, 1.0, width, cv::LINE_AA);
  cv::line(*rgb, a, b, Scaled(tone, 0.7), width + 2, cv::LINE_AA);
  cv::line(*rgb, a, b, tone, std::max(1, width - 6), cv::LINE_AA);
}

void PaintPickets(Random* random, cv::Mat* rgb, cv::Mat* alpha) {
  for (int i = 0; i < 16; ++i) {
    const int top = random->Integer(8, 40);
    Bar(rgb, alpha, {i * 32 + 3, top, 25, kTextureSize - top}, Jitter(Rgb(206, 200, 188), 0.18, random));
  }
  for (const int y : {120, 380})
    Bar(rgb, alpha, {0, y, kTextureSize, 34}, Jitter(Rgb(180, 172, 160), 0.1, random));
}

void PaintBars(const cv::Scalar& tone, int count, int width, Random* random, cv::Mat* rgb, cv::Mat* alpha) {
  const int step = kTextureSize / count;
  for (int i = 0; i < count; ++i)
    Bar(rgb, alpha, {i * step, 16, width, kTextureSize - 16}, Jitter(tone, 0.2, random));
  for (const int y : {26, 448}) Bar(rgb, alpha, {0, y, kTextureSize, 30}, Jitter(tone, 0.1, random));
  Bar(rgb, alpha, {kTextureSize / 2 - 16, 0, 34, kTextureSize}, Scaled(tone, 1.2));
}

void PaintMeshFence(Random* random, cv::Mat* rgb, cv::Mat* alpha) {
  const cv::Scalar wire = Rgb(150, 158, 152);
  for (int i = -16; i < 32; ++i) {
    Beam(rgb, alpha, {i * 32, 0}, {i * 32 + 512, 512}, 7, Jitter(wire, 0.2, random));
    Beam(rgb, alpha, {i * 32, 512}, {i * 32 + 512, 0}, 7, Jitter(wire, 0.2, random));
  }
  Bar(rgb, alpha, {0, 0, 30, kTextureSize}, Rgb(110, 116, 112));
  Bar(rgb, alpha, {0, 0, kTextureSize, 24}, Rgb(120, 126, 122));
}

// The W-shaped steel rail on its posts.
void PaintGuardRail(Random* random, cv::Mat* rgb, cv::Mat* alpha) {
  for (int post = 0; post < 2; ++post) Bar(rgb, alpha, {100 + post * 256, 120, 44, 392}, Rgb(120, 122, 120));
  static const double kProfile[] = {0.7, 1.1, 0.8, 0.5, 0.8, 1.15, 0.75, 0.5};
  for (int band = 0; band < 8; ++band) {
    cv::rectangle(*rgb, cv::Rect(0, 60 + band * 28, kTextureSize, 29),
                  Scaled(Rgb(172, 176, 178), kProfile[band]), cv::FILLED);
  }
  cv::rectangle(*alpha, cv::Rect(0, 60, kTextureSize, 224), 1.0, cv::FILLED);
  Modulate(rgb, Noise(rgb->size(), {9, 9}, 4, 0.7, random), 0.1);
  DrawSpots(rgb, 60, 3, 9, 0.4, 0.8, random);
  DrawStreaks(rgb, 30, 0.4, random);
}

void PaintTruss(Random* random, cv::Mat* rgb, cv::Mat* alpha) {
  const cv::Scalar steel = Rgb(88, 116, 112);
  *rgb = Filled(rgb->size(), steel);
  Beam(rgb, alpha, {0, 500}, {256, 20}, 34, steel);
  Beam(rgb, alpha, {256, 20}, {512, 500}, 34, steel);
  Beam(rgb, alpha, {256, 20}, {256, 512}, 22, steel);
  Bar(rgb, alpha, {0, 0, kTextureSize, 54}, steel);
  Bar(rgb, alpha, {0, 456, kTextureSize, 56}, steel);
  Modulate(rgb, Noise(rgb->size(), {8, 8}, 5, 0.7, random), 0.14);
  for (int x = 8; x < kTextureSize; x += 22) {
    for (const int y : {12, 42, 470, 500})
      cv::circle(*rgb, {x, y}, 4, Rgb(150, 168, 164), cv::FILLED, cv::LINE_AA);
  }
  const cv::Mat rust = Noise(rgb->size(), {12, 12}, 4, 0.7, random);
  Blend(rgb, 0.8 * SmoothMask(rust, 1.2, 1.5), Rgb(126, 74, 44));
}

}  // namespace

void PaintBarrier(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha) {
  Random random(seed, 105, static_cast<uint64_t>(texture));
  alpha->setTo(0);
  *rgb = Filled(rgb->size(), Rgb(120, 120, 118));
  switch (texture) {
    case Texture::kFencePickets:
      return PaintPickets(&random, rgb, alpha);
    case Texture::kFenceBars:
      return PaintBars(Rgb(62, 70, 66), 12, 16, &random, rgb, alpha);
    case Texture::kFenceMesh:
      return PaintMeshFence(&random, rgb, alpha);
    case Texture::kRailing:
      return PaintBars(Rgb(104, 120, 128), 10, 18, &random, rgb, alpha);
    case Texture::kGuardRail:
      return PaintGuardRail(&random, rgb, alpha);
    default:
      return PaintTruss(&random, rgb, alpha);
  }
}

}  // namespace semmap::town
