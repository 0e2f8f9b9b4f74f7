#include <algorithm>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"
#include "client/town/textures.h"

namespace semmap::town {
namespace {

std::string ShopName(Random* random) {
  static const char* kOwners[] = {"Nord",   "Lindner", "Almas", "Petrov", "Rosa",   "Kobe",
                                  "Marlow", "Vega",    "Otto",  "Sava",   "Brandt", "Iris",
                                  "Dahl",   "Juno",    "Costa", "Meyer",  "Tane",   "Quill"};
  static const char* kTrades[] = {"BAKERY", "BOOKS",  "OPTIK",  "CAFE",  "FLOWERS", "SHOES",
                                  "HOTEL",  "BANK",   "MARKET", "PIZZA", "TOYS",    "MUSIC",
                                  "HAIR",   "DENTAL", "RADIO",  "TEA",   "SPORT",   "FISH",
                                  "TAILOR", "BIKES",  "PHARMA", "WINE",  "GALLERY", "KEYS"};
  const std::string owner = kOwners[random->Below(18)];
  const std::string trade = kTrades[random->Below(24)];
  switch (random->Below(4)) {
    case 0:
      return trade;
    case 1:
      return owner + " " + trade;
    case 2:
      return owner + " & Co";
    default:
      return trade + " " + std::to_string(random->Integer(2, 99));
  }
}

int AnyFont(Random* random) {
  static const int kFonts[] = {cv::FONT_HERSHEY_SIMPLEX, cv::FONT_HERSHEY_DUPLEX, cv::FONT_HERSHEY_COMPLEX,
                               cv::FONT_HERSHEY_TRIPLEX, cv::FONT_HERSHEY_SCRIPT_COMPLEX};
  return kFonts[random->Below(5)];
}

void PaintShopSigns(Random* random, cv::Mat* rgb) {
  for (int i = 0; i < 8; ++i) {
    cv::Mat board = (*rgb)(cv::Rect(0, i * 64, kTextureSize, 64));
    const bool dark = random->Chance(0.6);
    const double hue = random->Uniform(0, 360);
    const cv::Scalar ground = dark ? Hsv(hue, random->Uniform(0.4, 0.9), random->Uniform(0.12, 0.5))
                                   : Hsv(hue, random->Uniform(0.05, 0.5), random->Uniform(0.75, 0.95));
    board.setTo(ground);
    const cv::Scalar letters = dark ? Hsv(random->Uniform(30, 60), random->Uniform(0, 0.6), 0.95)
                                    : Hsv(random->Uniform(0, 360), 0.8, 0.3);
    cv::rectangle(board, cv::Rect(3, 3, board.cols - 6, 58), letters, 2, cv::LINE_AA);
    const int inset = random->Integer(14, 90);
    DrawText(&board, ShopName(random), {inset, 9, board.cols - 2 * inset, 48}, AnyFont(random), letters, 1.6);
    if (inset > 60)
      cv::circle(board, {34, 32}, 18, letters, random->Chance(0.5) ? 4 : cv::FILLED, cv::LINE_AA);
  }
  Modulate(rgb, Noise(rgb->size(), {8, 8}, 3, 0.6, random), 0.05);
}

void PaintPoster(cv::Mat poster, Random* random) {
  const double hue = random->Uniform(0, 360);
  poster.setTo(Hsv(hue, random->Uniform(0.1, 0.7), random->Uniform(0.5, 0.95)));
  for (int i = 0; i < 9; ++i) {
    const cv::Scalar tone = Hsv(std::fmod(hue + random->Uniform(0, 300), 360), random->Uniform(0.2, 0.9),
                                random->Uniform(0.15, 1.0));
    const cv::Point at(random->Below(poster.cols), random->Integer(poster.rows / 4, poster.rows * 3 / 4));
    if (random->Chance(0.5)) {
      cv::circle(poster, at, random->Integer(6, 40), tone, cv::FILLED, cv::LINE_AA);
    } else {
      const cv::Rect box(at, cv::Size(random->Integer(8, 60), random->Integer(8, 70)));
      cv::rectangle(poster, box, tone, cv::FILLED);
    }
  }
  static const char* kWords[] = {"CONCERT",  "CIRCUS", "VOTE",     "SUMMER",  "OPERA", "JAZZ",
                                 "MARATHON", "MUSEUM", "FESTIVAL", "THEATRE", "EXPO",  "FILM"};
  const cv::Scalar ink = random->Chance(0.5) ? Rgb(20, 18, 24) : Rgb(250, 246, 235);
  DrawText(&poster, kWords[random->Below(12)], {6, 10, poster.cols - 12, 40}, AnyFont(random), ink, 1.8);
  for (int line = 0; line < 4; ++line) {
    DrawText(&poster, std::to_string(random->Integer(1000, 99999)) + " " + kWords[random->Below(12)],
             {10, poster.rows - 62 + line * 14, poster.cols - 20, 10}, cv::FONT_HERSHEY_SIMPLEX, ink, 0.6);
  }
  cv::rectangle(poster, cv::Rect(0, 0, poster.cols, poster.rows), Rgb(60, 60, 62), 4);
}

void PaintPosters(Random* random, cv::Mat* rgb) {
  for (int i = 0; i < 8; ++i) PaintPoster((*rgb)(cv::Rect(i % 4 * 128, i / 4 * 256, 128, 256)), random);
}

// Paints on the canvas and marks what was painted as solid.
template <typename Draw>
void PaintCut(cv::Mat rgb, cv::Mat alpha, const Draw& draw) {
  cv::Mat shape = cv::Mat::zeros(rgb.size(), CV_32F);
  draw(&rgb, &shape);
  shape.copyTo(alpha);
}

void PaintGraffitiCell(cv::Mat rgb, cv::Mat alpha, Random* random) {
  const double hue = random->Uniform(0, 360);
  rgb.setTo(Hsv(hue, 0.8, 0.3));
  static const char* kTags[] = {"ZEK", "nova", "RIOT", "k2", "LOOP", "ars", "BONE", "mio", "SLAM", "83"};
  const std::string tag = kTags[random->Below(10)];
  const cv::Scalar fill = Hsv(std::fmod(hue + 120, 360), 0.7, 0.95);
  const int font = random->Chance(0.5) ? cv::FONT_HERSHEY_SCRIPT_COMPLEX : cv::FONT_HERSHEY_TRIPLEX;
  PaintCut(rgb, alpha, [&](cv::Mat* /*colour*/, cv::Mat* shape) {
    cv::putText(*shape, tag, {10, 82}, font, 1.9, 1.0, 16, cv::LINE_AA);
    for (int i = 0; i < 4; ++i) {
      cv::line(*shape, {random->Below(128), random->Below(128)}, {random->Below(128), random->Below(128)},
               1.0, 3, cv::LINE_AA);
    }
  });
  cv::putText(rgb, tag, {10, 82}, font, 1.9, fill, 5, cv::LINE_AA);
}

void PaintGraffiti(Random* random, cv::Mat* rgb, cv::Mat* alpha) {
  alpha->setTo(0);
  for (int i = 0; i < 16; ++i) {
    const cv::Rect cell(i % 4 * 128, i / 4 * 128, 128, 128);
    PaintGraffitiCell((*rgb)(cell), (*alpha)(cell), random);
  }
}

// A disc, triangle or rectangle, shrunk by `inset` texels.
void SignShape(cv::Mat* canvas, int shape, int inset, const cv::Scalar& colour) {
  if (shape == 0) {
    cv::circle(*canvas, {64, 64}, 58 - inset, colour, cv::FILLED, cv::LINE_AA);
  } else if (shape == 1 || shape == 3) {
    const int slope = inset * 7 / 4;
    std::vector<cv::Point> corners = {{64, 8 + slope}, {122 - slope, 116 - inset}, {6 + slope, 116 - inset}};
    if (shape == 3) {
      for (cv::Point& corner : corners) corner.y = 124 - corner.y;
    }
    cv::fillConvexPoly(*canvas, corners, colour, cv::LINE_AA);
  } else {
    cv::rectangle(*canvas, cv::Rect(8 + inset, 8 + inset, 112 - 2 * inset, 112 - 2 * inset), colour,
                  cv::FILLED);
  }
}

void PaintTrafficSign(int index, cv::Mat rgb, cv::Mat alpha, Random* random) {
  const int shape = index % 4;
  const cv::Scalar red = Rgb(196, 24, 32);
  const cv::Scalar blue = Rgb(20, 70, 160);
  const bool blue_disc = shape == 2 || (shape == 0 && index >= 8);
  rgb.setTo(blue_disc ? Rgb(240, 240, 240) : red);
  alpha.setTo(0);
  SignShape(&alpha, shape, 0, 1.0);
  SignShape(&rgb, shape, 9, blue_disc ? blue : Rgb(244, 244, 240));
  const cv::Scalar ink = blue_disc ? Rgb(244, 244, 244) : Rgb(22, 22, 24);
  static const char* kTexts[] = {"30", "!", "P", "!", "50", "A", "H", "S",
                                 "R",  "X", "P", "Y", "40", "B", "i", "W"};
  cv::Mat canvas = rgb;
  DrawText(&canvas, kTexts[index], shape == 1 ? cv::Rect(48, 52, 32, 52) : cv::Rect(34, 36, 60, 56),
           cv::FONT_HERSHEY_DUPLEX, ink, 2.2);
  Modulate(&canvas, Speckle(canvas.size(), 1.0, random), 0.02);
}

void PaintArrow(int kind, cv::Mat* shape) {
  cv::rectangle(*shape, cv::Rect(58, 44, 12, 80), 1.0, cv::FILLED);
  if (kind == 0) {
    cv::fillConvexPoly(*shape, std::vector<cv::Point>{{64, 4}, {86, 50}, {42, 50}}, 1.0, cv::LINE_AA);
    return;
  }
  const int sign = kind == 1 ? 1 : -1;
  cv::rectangle(*shape, cv::Rect(sign > 0 ? 58 : 34, 44, 36, 12), 1.0, cv::FILLED);
  const std::vector<cv::Point> head = {{64 + sign * 28, 24}, {64 + sign * 28, 76}, {64 + sign * 58, 50}};
  cv::fillConvexPoly(*shape, head, 1.0, cv::LINE_AA);
}

void PaintManhole(cv::Mat rgb, cv::Mat alpha, Random* random) {
  rgb.setTo(Rgb(70, 68, 68));
  cv::circle(alpha, {64, 64}, 60, 1.0, cv::FILLED, cv::LINE_AA);
  cv::circle(rgb, {64, 64}, 52, Rgb(104, 100, 96), 4, cv::LINE_AA);
  for (int y = 16; y < 116; y += 12) {
    for (int x = 16; x < 116; x += 12) {
      if ((x - 64) * (x - 64) + (y - 64) * (y - 64) > 45 * 45) continue;
      cv::rectangle(rgb, cv::Rect(x, y, 6, 6), Jitter(Rgb(120, 116, 110), 0.2, random), cv::FILLED);
    }
  }
}

// A mended place of the asphalt, darker or lighter, with a tarred rim.
void PaintRoadPatch(cv::Mat rgb, cv::Mat alpha, Random* random) {
  std::vector<cv::Point> outline;
  const int corners = random->Integer(5, 9);
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * CV_PI * i / corners;
    const double radius = random->Uniform(38, 62);
    outline.emplace_back(static_cast<int>(64 + radius * std::cos(angle)),
                         static_cast<int>(64 + radius * std::sin(angle)));
  }
  cv::fillPoly(alpha, std::vector<std::vector<cv::Point>>{outline}, 1.0, cv::LINE_AA);
  rgb.setTo(random->Chance(0.6) ? Rgb(74, 74, 78) : Rgb(142, 140, 136));
  cv::Mat canvas = rgb;
  Modulate(&canvas, Speckle(rgb.size(), 0.9, random), 0.14);
  DrawSpots(&canvas, 60, 1, 3, 0.6, 1.5, random);
  cv::polylines(rgb, std::vector<std::vector<cv::Point>>{outline}, true, Rgb(44, 44, 46), 5, cv::LINE_AA);
}

void PaintRoadArrows(Random* random, cv::Mat* rgb, cv::Mat* alpha) {
  alpha->setTo(0);
  for (int i = 0; i < 16; ++i) {
    const cv::Rect box(i % 4 * 128, i / 4 * 128, 128, 128);
    cv::Mat colour = (*rgb)(box);
    cv::Mat shape = (*alpha)(box);
    if (i < 4) {
      colour.setTo(Rgb(224, 224, 218));
      PaintArrow(i % 3, &shape);
    } else if (i < 8) {
      PaintManhole(colour, shape, random);
    } else {
      PaintRoadPatch(colour, shape, random);
    }
  }
}

}  // namespace

void PaintSign(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* alpha) {
  Random random(seed, 103, static_cast<uint64_t>(texture));
  if (texture <= Texture::kShopSigns3) return PaintShopSigns(&random, rgb);
  if (texture <= Texture::kPosters1) return PaintPosters(&random, rgb);
  if (texture == Texture::kGraffiti) return PaintGraffiti(&random, rgb, alpha);
  if (texture == Texture::kRoadArrows) return PaintRoadArrows(&random, rgb, alpha);
  for (int i = 0; i < 16; ++i) {
    const cv::Rect cell(i % 4 * 128, i / 4 * 128, 128, 128);
    PaintTrafficSign(i, (*rgb)(cell), (*alpha)(cell), &random);
  }
}

}  // namespace semmap::town
