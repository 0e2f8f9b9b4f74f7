#include <cmath>

#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"
#include "client/town/textures.h"

namespace semmap::town {
namespace {

// Woven cloth: plain, striped, chequered or with a print.
void PaintCloth(cv::Mat cell, Random* random) {
  const double hue = random->Uniform(0, 360);
  const cv::Scalar ground = Hsv(hue, random->Uniform(0.1, 0.7), random->Uniform(0.2, 0.85));
  const cv::Scalar other = Hsv(std::fmod(hue + random->Uniform(30, 300), 360), random->Uniform(0.1, 0.7),
                               random->Uniform(0.2, 0.95));
  cell.setTo(ground);
  const int kind = random->Below(4);
  for (int i = 0; i + 11 <= 128; i += 24) {
    if (kind == 1 || kind == 2) cell(cv::Rect(0, i, 128, 11)).setTo(other);
    if (kind == 2) cell(cv::Rect(i, 0, 7, 128)).setTo(Scaled(other, 0.7));
  }
  if (kind == 3) {
    cv::circle(cell, {64, 50}, 22, other, cv::FILLED, cv::LINE_AA);
    DrawText(&cell, std::to_string(random->Integer(1, 99)), {46, 36, 36, 28}, cv::FONT_HERSHEY_DUPLEX, ground,
             1.6);
  }
  cv::line(cell, {64, 0}, {64, 128}, Scaled(ground, 0.6), 2);
  for (int i = 0; i < 5; ++i) {  // folds
    const int x = random->Below(128);
    cv::line(cell, {x, 0}, {x + random->Integer(-30, 30), 128}, Scaled(ground, 0.75), 3, cv::LINE_AA);
  }
}

void PaintFace(cv::Mat cell, Random* random) {
  const cv::Scalar skin =
      Hsv(random->Uniform(14, 30), random->Uniform(0.25, 0.5), random->Uniform(0.35, 0.92));
  const cv::Scalar hair = Hsv(random->Uniform(10, 45), random->Uniform(0.1, 0.6), random->Uniform(0.06, 0.6));
  cell.setTo(hair);
  // The middle of the texture looks forward.
  cv::ellipse(cell, {64, 76}, {26, 50}, 0, 0, 360, skin, cv::FILLED, cv::LINE_AA);
  for (const int x : {54, 74}) {
    cv::ellipse(cell, {x, 62}, {6, 4}, 0, 0, 360, Rgb(240, 238, 232), cv::FILLED, cv::LINE_AA);
    cv::circle(cell, {x, 62}, 3, Rgb(40, 32, 28), cv::FILLED, cv::LINE_AA);
    cv::line(cell, {x - 7, 53}, {x + 7, 52}, Scaled(hair, 0.8), 3, cv::LINE_AA);
  }
  cv::line(cell, {64, 64}, {66, 78}, Scaled(skin, 0.75), 3, cv::LINE_AA);
  cv::ellipse(cell, {64, 92}, {9, 3}, 0, 0, 360, Rgb(160, 70, 64), cv::FILLED, cv::LINE_AA);
}

void PaintDisc(cv::Mat cell, const cv::Scalar& tone) {
  cell.setTo(Rgb(22, 24, 24));
  cv::circle(cell, {64, 64}, 54, tone, cv::FILLED, cv::LINE_AA);
  cv::circle(cell, {64, 64}, 56, Rgb(60, 62, 62), 4, cv::LINE_AA);
}

// Signal discs lit and dark, lamp glass, the housing's metal.
void PaintLights(Random* random, cv::Mat* rgb) {
  const cv::Scalar discs[] = {Rgb(255, 60, 44), Rgb(255, 186, 40), Rgb(70, 255, 140), Rgb(56, 20, 18),
                              Rgb(58, 46, 16),  Rgb(14, 52, 30),   Rgb(250, 244, 220)};
  for (int i = 0; i < 16; ++i) {
    cv::Mat cell = (*rgb)(cv::Rect(i % 4 * 128, i / 4 * 128, 128, 128));
    if (i < 7) {
      PaintDisc(cell, discs[i]);
    } else {
      cell.setTo(Jitter(Rgb(60, 64, 62), 0.3, random));
      for (int y = 0; y < 128; y += 16) cell.row(y).setTo(Rgb(34, 36, 36));
    }
  }
}

// Fronts of bins, boxes and machines of the street.
void PaintBinCell(cv::Mat cell, Random* random) {
  const cv::Scalar tone =
      Hsv(random->Uniform(0, 360), random->Uniform(0.2, 0.8), random->Uniform(0.25, 0.75));
  cell.setTo(tone);
  FillRect(&cell, {0, 0, 128, 20}, Scaled(tone, 0.55));
  FillRect(&cell, {24, 30, 80, 14}, Rgb(24, 24, 24));
  FillRect(&cell, {30, 56, 68, 44}, Jitter(Rgb(226, 224, 214), 0.1, random));
  static const char* kLabels[] = {"GLASS", "POST", "PAPER", "230V", "WASTE", "SALT", "NEWS", "BIO"};
  DrawText(&cell, kLabels[random->Below(8)], {34, 62, 60, 18}, cv::FONT_HERSHEY_DUPLEX, Rgb(30, 30, 34), 1.2);
  for (int i = 0; i < 6; ++i)
    cv::line(cell, {random->Below(128), random->Below(128)}, {random->Below(128), 127}, Scaled(tone, 0.6), 1,
             cv::LINE_AA);
  cv::rectangle(cell, cv::Rect(0, 0, 128, 128), Scaled(tone, 0.4), 4);
}

}  // namespace

void PaintPeople(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* /*alpha*/) {
  Random random(seed, 107, static_cast<uint64_t>(texture));
  if (texture == Texture::kLights) return PaintLights(&random, rgb);
  for (int i = 0; i < 16; ++i) {
    cv::Mat cell = (*rgb)(cv::Rect(i % 4 * 128, i / 4 * 128, 128, 128));
    if (texture == Texture::kFaces) {
      PaintFace(cell, &random);
    } else if (texture == Texture::kBins) {
      PaintBinCell(cell, &random);
    } else {
      PaintCloth(cell, &random);
    }
  }
  Modulate(rgb, Speckle(rgb->size(), 0.8, &random), 0.05);
}

}  // namespace semmap::town
