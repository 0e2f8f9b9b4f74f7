#include <algorithm>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"
#include "client/town/textures.h"

namespace semmap::town {
namespace {

// What the glass mirrors: sky above, the street's other side below, a bright slanting band.
void PaintGlass(cv::Mat part, Random* random) {
  const double dark = random->Uniform(0.5, 1.0);
  const int skyline = static_cast<int>(part.rows * random->Uniform(0.25, 0.6));
  const cv::Scalar sky = Jitter(Rgb(126, 148, 168), 0.25, random);
  for (int y = 0; y < part.rows; ++y) {
    const double t = static_cast<double>(y) / part.rows;
    part.row(y).setTo(Scaled(sky, dark * (1.0 - 0.6 * t)));
  }
  int x = 0;
  while (x < part.cols) {
    const int width = random->Integer(std::max(2, part.cols / 8), std::max(3, part.cols / 3));
    const int top = std::clamp(skyline + random->Integer(-part.rows / 6, part.rows / 6), 0, part.rows - 1);
    const cv::Rect house = cv::Rect(x, top, width, part.rows - top) & cv::Rect(0, 0, part.cols, part.rows);
    part(house).setTo(Jitter(Rgb(44, 44, 48), 0.4, random));
    x += width;
  }
  if (random->Chance(0.5)) {
    const int left = random->Integer(-part.cols / 2, part.cols);
    const std::vector<cv::Point> band = {{left, part.rows},
                                         {left + part.cols / 4, part.rows},
                                         {left + part.cols * 3 / 4, 0},
                                         {left + part.cols / 2, 0}};
    cv::Mat bright = part.clone();
    cv::fillConvexPoly(bright, band, Rgb(176, 190, 202), cv::LINE_AA);
    cv::addWeighted(part, 0.7, bright, 0.3, 0, part);
  }
}

void PaintCurtains(cv::Mat part, Random* random) {
  const int kind = random->Below(5);
  const cv::Scalar cloth = random->Chance(0.6)
                               ? Jitter(Rgb(214, 208, 196), 0.15, random)
                               : Hsv(random->Uniform(0, 360), 0.35, random->Uniform(0.4, 0.8));
  if (kind == 0) {  // drawn to both sides, in folds
    const int width = random->Integer(part.cols / 8, part.cols / 3);
    for (int x = 0; x < width; ++x) {
      const double fold = 0.75 + 0.25 * std::sin(x * 1.3);
      part.col(x).setTo(Scaled(cloth, fold));
      part.col(part.cols - 1 - x).setTo(Scaled(cloth, fold));
    }
  } else if (kind == 1) {  // a blind, let down part of the way
    const int drop = random->Integer(part.rows / 6, part.rows * 4 / 5);
    for (int y = 0; y < drop; ++y) part.row(y).setTo(Scaled(cloth, y % 5 == 4 ? 0.6 : 0.95));
  } else if (kind == 2) {  // flowers on the sill
    for (int i = 0; i < 30; ++i) {
      const cv::Point at(random->Below(part.cols), part.rows - 1 - random->Below(std::max(2, part.rows / 4)));
      const cv::Scalar petal = random->Chance(0.6) ? Hsv(random->Uniform(80, 130), 0.6, 0.4)
                                                   : Hsv(random->Uniform(-60, 60) + 360, 0.8, 0.9);
      cv::circle(part, at, random->Integer(1, 4), petal, cv::FILLED, cv::LINE_AA);
    }
  }
}

struct WindowStyle {
  int columns;
  int rows;
  double frame;  // share of the cell
  double bar;
  bool shutters;
};

void PaintWindow(cv::Mat cell, const WindowStyle& style, Random* random) {
  static const cv::Scalar kFrames[] = {Rgb(232, 230, 224), Rgb(92, 70, 50), Rgb(62, 66, 70), Rgb(70, 96, 84),
                                       Rgb(206, 196, 174)};
  const cv::Scalar frame = Jitter(kFrames[random->Below(5)], 0.1, random);
  cell.setTo(frame);
  const int border = std::max(3, static_cast<int>(cell.cols * style.frame));
  int left = border;
  int right = cell.cols - border;
  if (style.shutters) {
    const cv::Scalar shutter = Hsv(random->Uniform(80, 220), 0.4, random->Uniform(0.3, 0.6));
    left = cell.cols / 4;
    right = cell.cols - left;
    for (int y = 0; y < cell.rows; ++y) {
      const cv::Scalar slat = Scaled(shutter, y % 6 < 2 ? 0.6 : 1.0);
      cell(cv::Rect(0, y, left - 4, 1)).setTo(slat);
      cell(cv::Rect(right + 4, y, cell.cols - right - 4, 1)).setTo(slat);
    }
  }
  cv::Mat glass = cell(cv::Rect(left, border, right - left, cell.rows - 2 * border));
  PaintGlass(glass, random);
  PaintCurtains(glass, random);
  const int bar = std::max(2, static_cast<int>(cell.cols * style.bar));
  for (int i = 1; i < style.columns; ++i) {
    glass(cv::Rect(glass.cols * i / style.columns - bar / 2, 0, bar, glass.rows)).setTo(Scaled(frame, 0.95));
  }
  for (int i = 1; i < style.rows; ++i) {
    glass(cv::Rect(0, glass.rows * i / style.rows - bar / 2, glass.cols, bar)).setTo(Scaled(frame, 0.95));
  }
  cv::rectangle(cell, cv::Rect(left, border, right - left, cell.rows - 2 * border), Scaled(frame, 0.55), 1);
}

void PaintWindows(int variant, Random* random, cv::Mat* rgb) {
  static const WindowStyle kStyles[] = {{2, 3, 0.05, 0.04, false}, {2, 2, 0.06, 0.06, false},
                                        {1, 1, 0.04, 0.04, false}, {2, 2, 0.04, 0.03, true},
                                        {3, 1, 0.04, 0.03, false}, {4, 5, 0.04, 0.025, false}};
  constexpr int kCell = kTextureSize / 4;
  for (int i = 0; i < 16; ++i) {
    PaintWindow((*rgb)(cv::Rect(i % 4 * kCell, i / 4 * kCell, kCell, kCell)), kStyles[variant], random);
  }
  Modulate(rgb, Speckle(rgb->size(), 0.8, random), 0.02);
}

void PaintDoor(cv::Mat cell, Random* random) {
  const cv::Scalar wood = random->Chance(0.5) ? Hsv(random->Uniform(15, 40), 0.5, random->Uniform(0.25, 0.5))
                                              : Hsv(random->Uniform(0, 360), 0.5, random->Uniform(0.2, 0.55));
  cell.setTo(wood);
  const int transom = cell.rows / 5;
  PaintGlass(cell(cv::Rect(8, 8, cell.cols - 16, transom - 12)), random);
  const int panels = random->Integer(1, 2);
  for (int column = 0; column < panels; ++column) {
    for (int row = 0; row < 3; ++row) {
      const int w = (cell.cols - 16) / panels;
      const cv::Rect box(8 + column * w + 5, transom + 8 + row * (cell.rows - transom - 12) / 3, w - 10,
                         (cell.rows - transom - 12) / 3 - 10);
      cv::rectangle(cell, box, Scaled(wood, 0.6), 3, cv::LINE_AA);
      cv::rectangle(cell, box + cv::Point(2, 2), Scaled(wood, 1.35), 1, cv::LINE_AA);
      if (row == 0 && random->Chance(0.4)) PaintGlass(cell(box), random);
    }
  }
  cv::circle(cell, {cell.cols * 4 / 5, cell.rows * 3 / 5}, 4, Rgb(220, 190, 90), cv::FILLED, cv::LINE_AA);
  FillRect(&cell, {cell.cols * 0.3, cell.rows * 0.72, cell.cols * 0.4, 9}, Rgb(190, 176, 120));
  DrawText(&cell, std::to_string(random->Integer(1, 199)), {cell.cols / 3, transom + 4, cell.cols / 3, 22},
           cv::FONT_HERSHEY_DUPLEX, Rgb(240, 236, 220), 1.0);
}

void PaintDoors(Random* random, cv::Mat* rgb) {
  for (int i = 0; i < 8; ++i) PaintDoor((*rgb)(cv::Rect(i % 4 * 128, i / 4 * 256, 128, 256)), random);
  Modulate(rgb, Speckle(rgb->size(), 0.8, random), 0.03);
}

// Goods on shelves behind the glass.
void PaintGoods(cv::Mat part, Random* random) {
  const int shelves = random->Integer(2, 4);
  const double hue = random->Uniform(0, 360);
  for (int shelf = 0; shelf < shelves; ++shelf) {
    const int floor = part.rows * (shelf + 1) / shelves - 4;
    part(cv::Rect(0, floor, part.cols, 4)).setTo(Rgb(120, 104, 84));
    int x = random->Integer(0, 10);
    while (x < part.cols - 6) {
      const int w = random->Integer(6, 30);
      const int h = random->Integer(8, std::max(9, part.rows / shelves - 10));
      const cv::Rect box = cv::Rect(x, floor - h, w, h) & cv::Rect(0, 0, part.cols, part.rows);
      const cv::Scalar tone = Hsv(std::fmod(hue + random->Uniform(-70, 70) + 360, 360),
                                  random->Uniform(0.2, 0.8), random->Uniform(0.3, 0.95));
      part(box).setTo(tone);
      if (box.height > 12 && box.width > 8) {
        part(cv::Rect(box.x + 2, box.y + box.height / 3, box.width - 4, box.height / 4))
            .setTo(Rgb(236, 232, 220));
      }
      x += w + random->Integer(1, 12);
    }
  }
}

void PaintShopWindow(cv::Mat glass, Random* random) {
  PaintGlass(glass, random);
  cv::Mat inside = glass.clone();
  PaintGoods(inside, random);
  cv::addWeighted(glass, 0.35, inside, 0.6, 0, glass);
  static const char* kNotes[] = {"SALE",  "OPEN", "-50%",  "NEW",     "24h",
                                 "FRESH", "CAFE", "TODAY", "2 for 1", "ATM"};
  if (random->Chance(0.75)) {
    const int w = random->Integer(glass.cols / 4, glass.cols / 2);
    const cv::Rect note(random->Below(glass.cols - w), random->Below(std::max(1, glass.rows * 2 / 3)), w,
                        glass.rows / 4);
    const cv::Scalar paper =
        random->Chance(0.5) ? Hsv(random->Uniform(0, 60), 0.85, 0.9) : Rgb(240, 240, 236);
    cv::Mat part = glass(note & cv::Rect(0, 0, glass.cols, glass.rows));
    part.setTo(paper);
    DrawText(&part, kNotes[random->Below(10)], {4, 3, part.cols - 8, part.rows - 6}, cv::FONT_HERSHEY_DUPLEX,
             paper[1] > 0.8 && paper[2] > 0.8 ? Rgb(180, 20, 30) : Rgb(24, 24, 28), 1.3);
  }
}

void PaintShop(cv::Mat front, Random* random) {
  const cv::Scalar frame = random->Chance(0.5)
                               ? Hsv(random->Uniform(0, 360), 0.45, random->Uniform(0.18, 0.5))
                               : Jitter(Rgb(70, 70, 74), 0.4, random);
  front.setTo(frame);
  const int plinth = random->Integer(20, 56);
  const int door = random->Integer(0, 3);  // which of the four bays
  for (int bay = 0; bay < 4; ++bay) {
    const int x = bay * front.cols / 4 + 5;
    const int width = front.cols / 4 - 10;
    const int bottom = bay == door ? 6 : plinth;
    cv::Mat glass = front(cv::Rect(x, 12, width, front.rows - 12 - bottom));
    PaintShopWindow(glass, random);
    if (bay == door) {
      cv::rectangle(front, cv::Rect(x + 4, 40, width - 8, front.rows - 46), Scaled(frame, 1.5), 5,
                    cv::LINE_AA);
      FillRect(&front, {x + width * 0.78, front.rows * 0.55, 4, 34}, Rgb(210, 206, 190));
    }
  }
  for (int y = front.rows - plinth; y < front.rows; y += 12) front.row(y) *= 0.6;
}

}  // namespace

void PaintOpening(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* /*alpha*/) {
  Random random(seed, 102, static_cast<uint64_t>(texture));
  if (texture <= Texture::kWindows5) {
    return PaintWindows(static_cast<int>(texture) - static_cast<int>(Texture::kWindows0), &random, rgb);
  }
  if (texture == Texture::kDoors) return PaintDoors(&random, rgb);
  PaintShop((*rgb)(cv::Rect(0, 0, kTextureSize, kTextureSize / 2)), &random);
  PaintShop((*rgb)(cv::Rect(0, kTextureSize / 2, kTextureSize, kTextureSize / 2)), &random);
  Modulate(rgb, Speckle(rgb->size(), 0.8, &random), 0.02);
}

}  // namespace semmap::town
