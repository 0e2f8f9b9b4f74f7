#include "client/cli/map_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/chart.h"
#include "client/cli/class_names.h"
#include "client/cli/map_projection.h"
#include "slam/semantics/taxonomy.h"

namespace semmap::client {
namespace {

const cv::Scalar kInk(60, 50, 45);
const cv::Scalar kFrame(200, 196, 192);
const cv::Scalar kGridColour(226, 223, 220);
const cv::Scalar kUnknownColour(190, 190, 190);
const cv::Scalar kWhite(255, 255, 255);
// Of the vehicles' paths: none is a colour of a class that is seen much.
const std::array<cv::Scalar, 5> kPathColours = {cv::Scalar(0, 0, 230), cv::Scalar(230, 120, 0),
                                                cv::Scalar(0, 140, 255), cv::Scalar(200, 0, 160),
                                                cv::Scalar(0, 0, 0)};
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kTextScale = 0.55;
constexpr double kTitleScale = 0.72;
constexpr int kTitleHeight = 56;
constexpr int kLegendWidth = 250;
constexpr int kLegendLine = 26;
constexpr int kGap = 16;
constexpr int kSubpixelBits = 4;
// A point is drawn as large as this on the ground, within bounds of pixels.
constexpr double kPointSize_m = 0.16;
constexpr double kMinRadius = 1.0;
constexpr double kMaxRadius = 3.5;
constexpr int kPathWidth = 3;
constexpr int kGridLines = 12;

cv::Point Fixed(const cv::Point2d& p) {
  const double factor = 1 << kSubpixelBits;
  return {cvRound(p.x * factor), cvRound(p.y * factor)};
}

void DrawText(cv::Mat* picture, const std::string& text, const cv::Point& left_middle, double scale) {
  int baseline = 0;
  const cv::Size size = cv::getTextSize(text, kFont, scale, 1, &baseline);
  cv::putText(*picture, text, {left_middle.x, left_middle.y + size.height / 2}, kFont, scale, kInk, 1,
              cv::LINE_AA);
}

cv::Scalar PathColour(size_t index) { return kPathColours[index % kPathColours.size()]; }

struct Dot {
  MapProjection::Pixel pixel;
  uint8_t semantic_class = 255;
};

void DrawPoints(const GroundScene& scene, const MapProjection& projection, cv::Mat* picture) {
  std::vector<Dot> dots;
  dots.reserve(scene.points.size());
  for (const GroundScene::Point& point : scene.points) {
    if (const auto pixel = projection.Project(point.position.cast<double>())) {
      dots.push_back({*pixel, point.semantic_class});
    }
  }
  std::stable_sort(dots.begin(), dots.end(),
                   [](const Dot& a, const Dot& b) { return a.pixel.nearness < b.pixel.nearness; });
  for (const Dot& dot : dots) {
    const double radius = std::clamp(0.5 * kPointSize_m * dot.pixel.scale, kMinRadius, kMaxRadius);
    cv::circle(*picture, Fixed(dot.pixel.at), cvRound(radius * (1 << kSubpixelBits)),
               ClassColour(dot.semantic_class), cv::FILLED, cv::LINE_AA, kSubpixelBits);
  }
}

void DrawLine(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const MapProjection& projection,
              const cv::Scalar& colour, int width, cv::Mat* picture) {
  const auto a = projection.Project(from);
  const auto b = projection.Project(to);
  if (a && b) cv::line(*picture, Fixed(a->at), Fixed(b->at), colour, width, cv::LINE_AA, kSubpixelBits);
}

// White beside the lines, so that they stand out from the points.
void DrawPaths(const GroundScene& scene, const MapProjection& projection, cv::Mat* picture) {
  for (size_t i = 0; i < scene.paths.size(); ++i) {
    const std::vector<Eigen::Vector3d>& positions = scene.paths[i].positions;
    for (const bool border : {true, false}) {
      for (size_t j = 1; j < positions.size(); ++j) {
        DrawLine(positions[j - 1], positions[j], projection, border ? kWhite : PathColour(i),
                 border ? kPathWidth + 3 : kPathWidth, picture);
      }
    }
    if (positions.empty()) continue;
    if (const auto start = projection.Project(positions.front())) {
      cv::circle(*picture, start->at, 7, kWhite, cv::FILLED, cv::LINE_AA);
      cv::circle(*picture, start->at, 5, PathColour(i), cv::FILLED, cv::LINE_AA);
    }
  }
}

// Squares of a round length on the ground, for the eye to measure by.
void DrawGround(const GroundScene& scene, const MapProjection& projection, cv::Mat* picture) {
  const Eigen::Vector3d low = scene.box.min();
  const Eigen::Vector3d high = scene.box.max();
  const double step = RoundLength(scene.box.sizes().head<2>().maxCoeff() / kGridLines * 2);
  const double z = scene.ground_height;
  for (double x = std::ceil(low.x() / step) * step; x <= high.x(); x += step) {
    DrawLine({x, low.y(), z}, {x, high.y(), z}, projection, kGridColour, 1, picture);
  }
  for (double y = std::ceil(low.y() / step) * step; y <= high.y(); y += step) {
    DrawLine({low.x(), y, z}, {high.x(), y, z}, projection, kGridColour, 1, picture);
  }
}

void DrawScaleBar(const MapProjection& projection, const cv::Rect& area, cv::Mat* picture) {
  const double pixels_per_metre = projection.Project(Eigen::Vector3d::Zero())->scale;
  const double length = RoundLength(0.2 * area.width / pixels_per_metre);
  const int pixels = cvRound(length * pixels_per_metre);
  const cv::Point left(area.x + kGap, area.br().y - kGap);
  cv::rectangle(*picture, {left.x - 8, left.y - 30}, {left.x + pixels + 8, left.y + 8}, kWhite, cv::FILLED);
  cv::line(*picture, left, {left.x + pixels, left.y}, kInk, 2);
  for (const int x : {left.x, left.x + pixels}) cv::line(*picture, {x, left.y - 5}, {x, left.y + 5}, kInk, 2);
  DrawText(picture, absl::StrFormat("%g m", length), {left.x + 6, left.y - 16}, kTextScale);
}

void DrawView(const GroundScene& scene, bool perspective, const cv::Rect& area, cv::Mat* picture) {
  cv::Mat view = (*picture)(area);
  const cv::Rect all(0, 0, area.width, area.height);
  const MapProjection projection =
      perspective ? MapProjection::Perspective(scene.box, all) : MapProjection::Top(scene.box, all);
  DrawGround(scene, projection, &view);
  DrawPoints(scene, projection, &view);
  DrawPaths(scene, projection, &view);
  if (!perspective) DrawScaleBar(projection, all, &view);
  cv::rectangle(view, all, kFrame, 1);
}

// Classes, most frequent first, then paths.
void DrawLegend(const GroundScene& scene, const cv::Point& corner, int height, cv::Mat* picture) {
  const std::array<size_t, 256> counts = CountClasses(scene);
  std::vector<std::pair<size_t, uint8_t>> classes;
  for (size_t id = 0; id < counts.size(); ++id) {
    if (counts[id] > 0) classes.emplace_back(counts[id], static_cast<uint8_t>(id));
  }
  std::stable_sort(classes.begin(), classes.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  cv::Point line(corner.x, corner.y + kLegendLine / 2);
  const auto room = [&] { return line.y + kLegendLine / 2 <= corner.y + height; };
  for (size_t i = 0; i < scene.paths.size() && room(); ++i, line.y += kLegendLine) {
    cv::line(*picture, line, {line.x + 24, line.y}, PathColour(i), kPathWidth, cv::LINE_AA);
    DrawText(picture, scene.paths[i].name, {line.x + 34, line.y}, kTextScale);
  }
  line.y += kLegendLine / 2;
  for (size_t i = 0; i < classes.size() && room(); ++i, line.y += kLegendLine) {
    const auto [count, id] = classes[i];
    cv::rectangle(*picture, {line.x, line.y - 8}, {line.x + 24, line.y + 8}, ClassColour(id), cv::FILLED);
    const std::string name = id == kUnknownClass ? "no class" : ClassName(id);
    DrawText(picture, absl::StrCat(name, "  ", count), {line.x + 34, line.y}, kTextScale);
  }
}

// Where the views go: both beside each other when the map is tall, else one below the other.
std::vector<std::pair<bool, cv::Rect>> Layout(const GroundScene& scene, const MapPictureOptions& options) {
  const int width = options.width - kLegendWidth - 3 * kGap;
  const double tallness = scene.box.sizes().y() / scene.box.sizes().x();
  const bool beside = options.view == MapView::kBoth && tallness > 0.8;
  const int each = beside ? (width - kGap) / 2 : width;
  const int top_height = cvRound(each * std::clamp(tallness, 0.25, 1.6));
  const int oblique_height = beside ? top_height : cvRound(0.45 * each);
  std::vector<std::pair<bool, cv::Rect>> views;
  cv::Point corner(kGap, kTitleHeight);
  if (options.view != MapView::kPerspective) {
    views.emplace_back(false, cv::Rect(corner, cv::Size(each, top_height)));
    if (beside) corner.x += each + kGap;
    if (!beside) corner.y += top_height + kGap;
  }
  if (options.view != MapView::kTop) {
    views.emplace_back(true, cv::Rect(corner, cv::Size(each, oblique_height)));
  }
  return views;
}

}  // namespace

cv::Scalar ClassColour(uint8_t semantic_class) {
  if (semantic_class >= kSemanticClassCount) return kUnknownColour;
  const auto& rgb = kSemanticClasses[semantic_class].rgb;
  return {static_cast<double>(rgb[2]), static_cast<double>(rgb[1]), static_cast<double>(rgb[0])};
}

double RoundLength(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= length) return factor * power;
  }
  return power;
}

cv::Mat DrawMapPicture(const GroundScene& scene, const MapPictureOptions& options) {
  const auto views = Layout(scene, options);
  int bottom = 0;
  for (const auto& [perspective, area] : views) bottom = std::max(bottom, area.br().y);
  cv::Mat picture(bottom + kGap, options.width, CV_8UC3, kWhite);
  DrawText(&picture, options.title, {kGap, kTitleHeight / 2}, kTitleScale);
  for (const auto& [perspective, area] : views) DrawView(scene, perspective, area, &picture);
  DrawLegend(scene, {options.width - kLegendWidth - kGap, kTitleHeight}, bottom - kTitleHeight, &picture);
  return picture;
}

}  // namespace semmap::client
