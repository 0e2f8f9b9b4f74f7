#include "client/cli/chart.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "absl/strings/str_format.h"

namespace semmap::client {
namespace {

const cv::Scalar kInk(60, 50, 45);
const cv::Scalar kFrame(150, 145, 140);
const cv::Scalar kGrid(232, 229, 226);
const cv::Scalar kWhite(255, 255, 255);
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kTickScale = 0.5;
constexpr double kLabelScale = 0.58;
constexpr double kTitleScale = 0.72;
// Room for tick labels and axis names around the plot.
constexpr int kMarginLeft = 96;
constexpr int kMarginRight = 28;
constexpr int kMarginTop = 52;
constexpr int kMarginBottom = 66;
constexpr int kTickPixelsX = 95;
constexpr int kTickPixelsY = 55;
constexpr int kSubpixelBits = 4;
constexpr double kRangeMargin = 0.04;

struct Range {
  double low = 0;
  double high = 1;

  double Size() const { return high - low; }
};

// Where data lands on the picture.
struct Axes {
  cv::Rect plot;
  Range x;
  Range y;

  cv::Point2d At(const cv::Point2d& p) const {
    return {plot.x + (p.x - x.low) / x.Size() * plot.width,
            plot.y + plot.height - (p.y - y.low) / y.Size() * plot.height};
  }
};

bool IsFinite(const cv::Point2d& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

template <typename Get>
Range RangeOf(const Chart& chart, Get get) {
  Range range{INFINITY, -INFINITY};
  for (const ChartSeries& series : chart.series) {
    for (const cv::Point2d& p : series.points) {
      if (!IsFinite(p)) continue;
      range.low = std::min(range.low, get(p));
      range.high = std::max(range.high, get(p));
    }
  }
  if (range.low > range.high) return {0, 1};
  if (range.Size() < 1e-12 * std::max(1.0, std::abs(range.high))) return {range.low - 0.5, range.high + 0.5};
  return range;
}

void Widen(Range* range, double by) {
  range->low -= by;
  range->high += by;
}

Axes FitAxes(const Chart& chart, const cv::Rect& plot) {
  Axes axes{plot, RangeOf(chart, [](const cv::Point2d& p) { return p.x; }),
            RangeOf(chart, [](const cv::Point2d& p) { return p.y; })};
  if (chart.y_from_zero) {
    axes.y = {0, axes.y.high * (1 + 2 * kRangeMargin)};
    if (!(axes.y.high > 0)) axes.y.high = 1;
    return axes;
  }
  Widen(&axes.x, kRangeMargin * axes.x.Size());
  Widen(&axes.y, kRangeMargin * axes.y.Size());
  if (!chart.equal_axes) return axes;
  const double unit = std::max(axes.x.Size() / plot.width, axes.y.Size() / plot.height);
  Widen(&axes.x, 0.5 * (unit * plot.width - axes.x.Size()));
  Widen(&axes.y, 0.5 * (unit * plot.height - axes.y.Size()));
  return axes;
}

cv::Point Fixed(const cv::Point2d& p) {
  const double factor = 1 << kSubpixelBits;
  return {cvRound(p.x * factor), cvRound(p.y * factor)};
}

void DrawLine(cv::Mat* picture, const cv::Point2d& a, const cv::Point2d& b, const cv::Scalar& colour,
              int width) {
  cv::line(*picture, Fixed(a), Fixed(b), colour, width, cv::LINE_AA, kSubpixelBits);
}

enum class Anchor { kLeft, kCentre, kRight };

// Text whose vertical middle is at p.y.
void DrawText(cv::Mat* picture, const std::string& text, cv::Point p, double scale, Anchor anchor,
              const cv::Scalar& colour = kInk) {
  int baseline = 0;
  const cv::Size size = cv::getTextSize(text, kFont, scale, 1, &baseline);
  if (anchor == Anchor::kCentre) p.x -= size.width / 2;
  if (anchor == Anchor::kRight) p.x -= size.width;
  cv::putText(*picture, text, {p.x, p.y + size.height / 2}, kFont, scale, colour, 1, cv::LINE_AA);
}

// Text that reads upwards, centred on p.
void DrawTextUpwards(cv::Mat* picture, const std::string& text, const cv::Point& p, double scale) {
  int baseline = 0;
  const cv::Size size = cv::getTextSize(text, kFont, scale, 1, &baseline);
  cv::Mat label(size.height + 2 * baseline, size.width + 4, CV_8UC3, kWhite);
  DrawText(&label, text, {label.cols / 2, label.rows / 2}, scale, Anchor::kCentre);
  cv::rotate(label, label, cv::ROTATE_90_COUNTERCLOCKWISE);
  const cv::Rect target(p.x - label.cols / 2, p.y - label.rows / 2, label.cols, label.rows);
  if ((target & cv::Rect({0, 0}, picture->size())) == target) label.copyTo((*picture)(target));
}

double StepOf(const std::vector<double>& ticks) { return ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0; }

void DrawGrid(const Axes& axes, cv::Mat* picture) {
  const cv::Rect& plot = axes.plot;
  const std::vector<double> x_ticks = NiceTicks(axes.x.low, axes.x.high, plot.width / kTickPixelsX);
  const std::vector<double> y_ticks = NiceTicks(axes.y.low, axes.y.high, plot.height / kTickPixelsY);
  for (const double tick : x_ticks) {
    const int x = cvRound(axes.At({tick, axes.y.low}).x);
    cv::line(*picture, {x, plot.y}, {x, plot.br().y}, kGrid, 1);
    cv::line(*picture, {x, plot.br().y}, {x, plot.br().y + 5}, kFrame, 1);
    DrawText(picture, FormatTick(tick, StepOf(x_ticks)), {x, plot.br().y + 18}, kTickScale, Anchor::kCentre);
  }
  for (const double tick : y_ticks) {
    const int y = cvRound(axes.At({axes.x.low, tick}).y);
    cv::line(*picture, {plot.x, y}, {plot.br().x, y}, kGrid, 1);
    cv::line(*picture, {plot.x - 5, y}, {plot.x, y}, kFrame, 1);
    DrawText(picture, FormatTick(tick, StepOf(y_ticks)), {plot.x - 10, y}, kTickScale, Anchor::kRight);
  }
}

// Draws the part of a line from `begin` pixels along it; returns the position along it at the end.
double DrawSegment(cv::Mat* picture, const cv::Point2d& a, const cv::Point2d& b, const ChartSeries& series,
                   double begin) {
  constexpr double kDash = 9;
  constexpr double kPeriod = 15;
  const int width = std::max(1, cvRound(series.width));
  const double length = cv::norm(b - a);
  if (!series.dashed) {
    DrawLine(picture, a, b, series.colour, width);
    return begin + length;
  }
  for (double at = -std::fmod(begin, kPeriod); at < length; at += kPeriod) {
    const double from = std::max(0.0, at);
    const double to = std::min(length, at + kDash);
    if (to > from)
      DrawLine(picture, a + (b - a) * (from / length), a + (b - a) * (to / length), series.colour, width);
  }
  return begin + length;
}

void DrawSeries(const Axes& axes, const ChartSeries& series, cv::Mat* picture) {
  double along = 0;
  for (size_t i = 1; i < series.points.size(); ++i) {
    if (!IsFinite(series.points[i - 1]) || !IsFinite(series.points[i])) continue;
    along = DrawSegment(picture, axes.At(series.points[i - 1]), axes.At(series.points[i]), series, along);
  }
}

void DrawMarker(const Axes& axes, const Chart::Marker& marker, cv::Mat* picture) {
  const cv::Point2d p = axes.At(marker.point);
  cv::circle(*picture, Fixed(p), 6 << kSubpixelBits, marker.colour, cv::FILLED, cv::LINE_AA, kSubpixelBits);
  cv::circle(*picture, Fixed(p), 6 << kSubpixelBits, kWhite, 1, cv::LINE_AA, kSubpixelBits);
  DrawText(picture, marker.name, {cvRound(p.x) + 12, cvRound(p.y) - 10}, kTickScale, Anchor::kLeft);
}

// The top corner of the plot through which fewer points run.
bool LegendGoesLeft(const Chart& chart, const Axes& axes, const cv::Size& box) {
  const cv::Rect left(axes.plot.tl(), box);
  const cv::Rect right(axes.plot.br().x - box.width, axes.plot.y, box.width, box.height);
  int in_left = 0;
  int in_right = 0;
  for (const ChartSeries& series : chart.series) {
    for (const cv::Point2d& point : series.points) {
      const cv::Point p = axes.At(point);
      in_left += left.contains(p) ? 1 : 0;
      in_right += right.contains(p) ? 1 : 0;
    }
  }
  return in_left < in_right;
}

void DrawLegend(const Chart& chart, const Axes& axes, cv::Mat* picture) {
  constexpr int kRow = 24;
  constexpr int kSample = 34;
  constexpr int kPad = 12;
  int text_width = 0;
  int baseline = 0;
  for (const ChartSeries& series : chart.series) {
    text_width = std::max(text_width, cv::getTextSize(series.name, kFont, kTickScale, 1, &baseline).width);
  }
  const cv::Size size(text_width + kSample + 3 * kPad, kRow * static_cast<int>(chart.series.size()) + kPad);
  const bool left = LegendGoesLeft(chart, axes, size + cv::Size(20, 20));
  const cv::Rect box({left ? axes.plot.x + 12 : axes.plot.br().x - size.width - 12, axes.plot.y + 12}, size);
  cv::rectangle(*picture, box, kWhite, cv::FILLED);
  cv::rectangle(*picture, box, kGrid, 1);
  int y = box.y + kPad / 2 + kRow / 2;
  for (const ChartSeries& series : chart.series) {
    DrawSegment(picture, cv::Point2d(box.x + kPad, y), cv::Point2d(box.x + kPad + kSample, y), series, 0);
    DrawText(picture, series.name, {box.x + 2 * kPad + kSample, y}, kTickScale, Anchor::kLeft);
    y += kRow;
  }
}

}  // namespace

std::vector<double> NiceTicks(double low, double high, int max_count) {
  std::vector<double> ticks;
  if (!(low < high) || !std::isfinite(low) || !std::isfinite(high) || max_count < 1) return ticks;
  const double raw = (high - low) / max_count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= raw * (1 - 1e-9)) step = factor * power;
  }
  const double first = std::ceil(low / step - 1e-9);
  for (int i = 0; i <= max_count + 1 && (first + i) * step <= high + 1e-9 * step; ++i) {
    ticks.push_back((first + i) * step);
  }
  return ticks;
}

std::string FormatTick(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  // No "-0".
  return absl::StrFormat("%.*f", decimals, std::abs(value) < 0.5 * step ? 0.0 : value);
}

void DrawChart(const Chart& chart, const cv::Rect& area, cv::Mat* picture) {
  const cv::Rect plot(area.x + kMarginLeft, area.y + kMarginTop, area.width - kMarginLeft - kMarginRight,
                      area.height - kMarginTop - kMarginBottom);
  const Axes axes = FitAxes(chart, plot);
  cv::rectangle(*picture, area, kWhite, cv::FILLED);
  DrawText(picture, chart.title, {plot.x, area.y + kMarginTop / 2}, kTitleScale, Anchor::kLeft);
  DrawGrid(axes, picture);
  cv::Mat inside = (*picture)(plot);
  Axes local = axes;
  local.plot.x = 0;
  local.plot.y = 0;
  for (const ChartSeries& series : chart.series) DrawSeries(local, series, &inside);
  cv::rectangle(*picture, plot, kFrame, 1);
  for (const Chart::Marker& marker : chart.markers) DrawMarker(axes, marker, picture);
  DrawLegend(chart, axes, picture);
  DrawText(picture, chart.x_label, {plot.x + plot.width / 2, area.br().y - 20}, kLabelScale, Anchor::kCentre);
  DrawTextUpwards(picture, chart.y_label, {area.x + 20, plot.y + plot.height / 2}, kLabelScale);
}

}  // namespace semmap::client
