#include <algorithm>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>

#include "client/town/texture_canvas.h"
#include "client/town/textures.h"
#include "client/town/vehicle_shapes.h"

// Layout of a vehicle's layer, in texels: side view 512 x 192 on top (front to the right), top view 512 x 192
// below, then front and rear, 256 x 128 each. Paint is white, to be tinted.
namespace semmap::town {
namespace {

const cv::Scalar kPaint(0.86, 0.86, 0.86);
const cv::Scalar kGlass(0.12, 0.14, 0.17);
const cv::Scalar kTrim(0.1, 0.1, 0.11);

cv::Point At(const VehicleShape& /*shape*/, double x, double z, int rows) {
  return {static_cast<int>((x + 0.5) * kTextureSize), static_cast<int>((1.0 - z) * rows)};
}

// Height of the roof line over x.
double OutlineHeight(const VehicleShape& shape, double x) {
  for (size_t i = 0; i + 1 < shape.outline.size(); ++i) {
    const glm::dvec2& a = shape.outline[i];
    const glm::dvec2& b = shape.outline[i + 1];
    if (b.x > a.x && x >= a.x && x <= b.x) return a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x);
  }
  return shape.belt;
}

void Mirror(cv::Mat glass, Random* random) {
  for (int i = 0; i < 3; ++i) {
    const int x = random->Below(std::max(1, glass.cols));
    cv::line(glass, {x, glass.rows}, {x + glass.rows / 2, 0}, Rgb(96, 108, 120), random->Integer(2, 9),
             cv::LINE_AA);
  }
}

void PaintSideGlass(const VehicleShape& shape, double from, double to, cv::Mat* side) {
  std::vector<cv::Point> outline = {At(shape, from, shape.belt, side->rows),
                                    At(shape, to, shape.belt, side->rows)};
  for (int i = 8; i >= 0; --i) {
    const double x = from + (to - from) * i / 8;
    outline.push_back(At(shape, x, std::max(shape.belt, OutlineHeight(shape, x) - 0.07), side->rows));
  }
  cv::fillPoly(*side, std::vector<std::vector<cv::Point>>{outline}, kGlass, cv::LINE_AA);
}

void PaintDoorLines(const VehicleShape& shape, int doors, cv::Mat* side) {
  for (int i = 0; i <= doors; ++i) {
    const double x = -0.24 + 0.42 * i / doors;
    cv::line(*side, At(shape, x, 0.2, side->rows), At(shape, x, shape.belt, side->rows), Scaled(kPaint, 0.4),
             2, cv::LINE_AA);
    if (i == doors) continue;
    const cv::Point handle = At(shape, x + 0.03, shape.belt - 0.09, side->rows);
    cv::rectangle(*side, cv::Rect(handle, cv::Size(20, 5)), kTrim, cv::FILLED);
  }
}

void PaintWheelArches(const VehicleShape& shape, cv::Mat* side) {
  for (const double axle : {shape.front_axle, shape.rear_axle}) {
    const cv::Size axes(static_cast<int>(shape.wheel_radius * 1.2 / shape.length * kTextureSize),
                        static_cast<int>(shape.wheel_radius * 1.2 / shape.height * side->rows));
    cv::ellipse(*side, At(shape, axle, shape.wheel_radius / shape.height, side->rows), axes, 0, 0, 360, kTrim,
                cv::FILLED, cv::LINE_AA);
  }
}

void PaintLettering(cv::Mat* side, Random* random) {
  static const char* kFirms[] = {"EXPRESS 24", "NORD LOGISTIC", "FRISCH & GUT", "ELEKTRO KOBE", "CITY LINE"};
  const cv::Scalar ink = Hsv(random->Uniform(0, 360), 0.85, 0.6);
  DrawText(side, kFirms[random->Below(5)], {40, 60, 260, 46}, cv::FONT_HERSHEY_DUPLEX, ink, 2.0);
  FillRect(side, {10, 116, 330, 9}, ink);
}

void PaintSide(const VehicleShape& shape, Random* random, cv::Mat side) {
  side.setTo(kPaint);
  for (int y = 0; y < side.rows; ++y) {  // the light falls off towards the sill
    const double t = static_cast<double>(y) / side.rows;
    side.row(y) *= 1.04 - 0.38 * t * t;
  }
  if (shape.texture == Texture::kBus) {
    for (int i = 0; i < 7; ++i) PaintSideGlass(shape, -0.47 + i * 0.135, -0.355 + i * 0.135, &side);
    FillRect(&side, {0, 132, kTextureSize, 12}, Rgb(180, 60, 50));
    DrawText(&side, "CITY BUS " + std::to_string(random->Integer(10, 99)), {120, 118, 220, 34},
             cv::FONT_HERSHEY_DUPLEX, kTrim, 2.0);
  } else if (shape.texture == Texture::kVan) {
    PaintSideGlass(shape, 0.2, 0.36, &side);
    PaintLettering(&side, random);
    PaintDoorLines(shape, 1, &side);
  } else {
    PaintSideGlass(shape, -0.38, -0.17, &side);
    PaintSideGlass(shape, -0.155, 0.02, &side);
    PaintSideGlass(shape, 0.035, 0.17, &side);
    PaintDoorLines(shape, 2, &side);
  }
  FillRect(&side, {0, side.rows * 0.83, kTextureSize, side.rows * 0.17}, kTrim);  // sill
  FillRect(&side, {0, side.rows * 0.68, kTextureSize, 4}, Scaled(kPaint, 0.55));  // moulding
  FillRect(&side, {490, side.rows * 0.45, 22, 16}, Rgb(236, 232, 214));
  FillRect(&side, {0, side.rows * 0.42, 16, 22}, Rgb(170, 30, 28));
  PaintWheelArches(shape, &side);
  Mirror(side(cv::Rect(140, 10, 200, 50)), random);
}

void PaintTop(const VehicleShape& shape, Random* random, cv::Mat top) {
  top.setTo(kPaint);
  const bool tall = shape.texture == Texture::kBus || shape.texture == Texture::kVan;
  if (!tall) {
    // Where the roof line slopes down lie wind screen and rear window.
    const auto glass = [&](double from, double to) {
      const cv::Rect box(At(shape, from, 0, 1).x, 18, static_cast<int>((to - from) * kTextureSize),
                         top.rows - 36);
      cv::Mat part = top(box & cv::Rect(0, 0, top.cols, top.rows));
      part.setTo(kGlass);
      Mirror(part, random);
    };
    glass(0.06, 0.19);
    glass(shape.texture == Texture::kCar0 ? -0.32 : -0.46, shape.texture == Texture::kCar0 ? -0.21 : -0.39);
    cv::line(top, {At(shape, 0.23, 0, 1).x, 30}, {480, 44}, Scaled(kPaint, 0.6), 2, cv::LINE_AA);
    cv::line(top, {At(shape, 0.23, 0, 1).x, top.rows - 30}, {480, top.rows - 44}, Scaled(kPaint, 0.6), 2,
             cv::LINE_AA);
  } else {
    for (int x = 40; x < 380; x += 56) FillRect(&top, {x * 1.0, 20, 3, top.rows - 40.0}, Scaled(kPaint, 0.7));
    top(cv::Rect(400, 16, 84, top.rows - 32)).setTo(kGlass);
  }
}

void PaintPlate(cv::Mat* end, cv::Rect box, Random* random) {
  FillRect(end, box, Rgb(238, 238, 232));
  const std::string text = std::string(1, static_cast<char>('A' + random->Below(26))) +
                           static_cast<char>('A' + random->Below(26)) + " " +
                           std::to_string(random->Integer(100, 9999));
  DrawText(end, text, {box.x + 3, box.y + 2, box.width - 6, box.height - 4}, cv::FONT_HERSHEY_DUPLEX,
           Rgb(20, 20, 24), 1.2);
}

// Front or rear: window above the belt, lamps, grille, plate.
void PaintEnd(const VehicleShape& shape, bool front, Random* random, cv::Mat end) {
  end.setTo(kPaint);
  const int belt = static_cast<int>((1 - shape.belt) * end.rows);
  const int top = static_cast<int>(end.rows * 0.06);
  cv::fillConvexPoly(end, std::vector<cv::Point>{{34, belt}, {52, top}, {204, top}, {222, belt}}, kGlass,
                     cv::LINE_AA);
  Mirror(end(cv::Rect(60, top, 130, std::max(4, belt - top))), random);
  const cv::Scalar lamp = front ? Rgb(244, 240, 222) : Rgb(190, 26, 26);
  const int lamp_y = belt + 10;
  for (const int x : {8, 204}) {
    cv::rectangle(end, cv::Rect(x, lamp_y, 44, 20), lamp, cv::FILLED);
    cv::rectangle(end, cv::Rect(x, lamp_y, 44, 20), kTrim, 2);
    cv::rectangle(end, cv::Rect(x + (x < 100 ? 30 : 0), lamp_y + 3, 13, 14), Rgb(230, 150, 40), cv::FILLED);
  }
  if (front) {
    for (int y = lamp_y; y < lamp_y + 24; y += 6) FillRect(&end, {64, y * 1.0, 128, 4}, kTrim);
    cv::circle(end, {128, lamp_y + 10}, 9, Rgb(220, 222, 226), cv::FILLED, cv::LINE_AA);
  } else {
    cv::line(end, {30, lamp_y - 4}, {226, lamp_y - 4}, Scaled(kPaint, 0.45), 2, cv::LINE_AA);
  }
  FillRect(&end, {0, end.rows * 0.8, 256, end.rows * 0.2}, kTrim);
  PaintPlate(&end, {92, lamp_y + 26, 72, 17}, random);
}

void PaintWheel(cv::Mat cell, Random* random) {
  cell.setTo(Rgb(24, 24, 26));
  const cv::Point middle(cell.cols / 2, cell.rows / 2);
  const int rim = cell.cols * 3 / 10;
  const cv::Scalar metal = Jitter(Rgb(170, 172, 176), 0.2, random);
  cv::circle(cell, middle, rim, Scaled(metal, 0.35), cv::FILLED, cv::LINE_AA);
  const int spokes = random->Integer(5, 9);
  for (int i = 0; i < spokes; ++i) {
    const double angle = 2 * CV_PI * i / spokes;
    const cv::Point tip(static_cast<int>(middle.x + rim * std::cos(angle)),
                        static_cast<int>(middle.y + rim * std::sin(angle)));
    cv::line(cell, middle, tip, metal, 9, cv::LINE_AA);
  }
  cv::circle(cell, middle, rim, metal, 5, cv::LINE_AA);
  cv::circle(cell, middle, rim / 4, metal, cv::FILLED, cv::LINE_AA);
}

}  // namespace

void PaintVehicle(Texture texture, uint64_t seed, cv::Mat* rgb, cv::Mat* /*alpha*/) {
  Random random(seed, 106, static_cast<uint64_t>(texture));
  if (texture == Texture::kWheels) {
    for (int i = 0; i < 16; ++i) PaintWheel((*rgb)(cv::Rect(i % 4 * 128, i / 4 * 128, 128, 128)), &random);
    return;
  }
  const VehicleShape& shape = ShapeOf(static_cast<int>(texture) - static_cast<int>(Texture::kCar0));
  PaintSide(shape, &random, (*rgb)(cv::Rect(0, 0, kTextureSize, 192)));
  PaintTop(shape, &random, (*rgb)(cv::Rect(0, 192, kTextureSize, 192)));
  PaintEnd(shape, true, &random, (*rgb)(cv::Rect(0, 384, 256, 128)));
  PaintEnd(shape, false, &random, (*rgb)(cv::Rect(256, 384, 256, 128)));
  Modulate(rgb, Noise(rgb->size(), {8, 8}, 3, 0.6, &random), 0.04);
}

}  // namespace semmap::town
