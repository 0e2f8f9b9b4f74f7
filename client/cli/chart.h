#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace semmap::client {

// A line through points in the chart's units.
struct ChartSeries {
  std::string name;
  cv::Scalar colour;  // BGR
  std::vector<cv::Point2d> points;
  double width = 2;
  bool dashed = false;
};

// One set of axes with lines in it. Sizes are in pixels of the picture.
struct Chart {
  std::string title;
  std::string x_label;
  std::string y_label;
  // One unit is as long on both axes: for maps.
  bool equal_axes = false;
  // The y axis begins at zero: for errors.
  bool y_from_zero = false;
  std::vector<ChartSeries> series;
  // Dots with a name, such as the start.
  struct Marker {
    std::string name;
    cv::Scalar colour;
    cv::Point2d point;
  };
  std::vector<Marker> markers;
};

// Round numbers that divide [low, high] into at most `max_count` steps: 1, 2 or 5 times a power of ten. Empty
// unless low < high, both finite.
std::vector<double> NiceTicks(double low, double high, int max_count);
// As many decimals as the step between ticks needs.
std::string FormatTick(double value, double step);

// Draws the chart into `area` of `picture` (CV_8UC3). Series with points that are not finite are cut there.
void DrawChart(const Chart& chart, const cv::Rect& area, cv::Mat* picture);

}  // namespace semmap::client
