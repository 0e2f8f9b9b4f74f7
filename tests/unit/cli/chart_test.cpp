#include "client/cli/chart.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace semmap::client {
namespace {

TEST(NiceTicks, AreRoundAndInside) {
  EXPECT_EQ(NiceTicks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(NiceTicks(-3, 3, 3), (std::vector<double>{-2, 0, 2}));
  for (const double size : {1e-6, 0.03, 0.7, 1.0, 42.0, 1e5}) {
    const std::vector<double> ticks = NiceTicks(0.1 * size, size, 6);
    EXPECT_GE(ticks.size(), 2U) << size;
    EXPECT_LE(ticks.size(), 7U) << size;
    EXPECT_GE(ticks.front(), 0.1 * size - 1e-9 * size);
    EXPECT_LE(ticks.back(), size * (1 + 1e-9));
  }
}

TEST(NiceTicks, AreNoneForWhatIsNoRange) {
  EXPECT_TRUE(NiceTicks(1, 1, 5).empty());
  EXPECT_TRUE(NiceTicks(2, 1, 5).empty());
  EXPECT_TRUE(NiceTicks(0, INFINITY, 5).empty());
  EXPECT_TRUE(NiceTicks(NAN, 1, 5).empty());
}

TEST(FormatTick, HasTheDecimalsOfTheStep) {
  EXPECT_EQ(FormatTick(250, 50), "250");
  EXPECT_EQ(FormatTick(0.30000000000000004, 0.1), "0.3");
  EXPECT_EQ(FormatTick(-1e-17, 0.02), "0.00");
  EXPECT_EQ(FormatTick(0.5, 0.25), "0.5");
}

int CountColour(const cv::Mat& picture, const cv::Scalar& colour) {
  cv::Mat mask;
  cv::inRange(picture, colour, colour, mask);
  return cv::countNonZero(mask);
}

Chart DiagonalChart() {
  // Not assigned one by one: GCC 12 warns of that without cause (its bug 105651).
  Chart chart{std::string("title"), std::string("x axis"), std::string("y axis"), false, false, {}, {}};
  chart.series = {{"line", cv::Scalar(200, 0, 0), {{0, 0}, {1, 1}, {2, 2}}, 3, false}};
  return chart;
}

TEST(DrawChart, DrawsTheSeriesWithinItsArea) {
  cv::Mat picture(500, 700, CV_8UC3, cv::Scalar::all(255));
  const cv::Rect area(100, 50, 500, 400);
  DrawChart(DiagonalChart(), area, &picture);
  EXPECT_GT(CountColour(picture, cv::Scalar(200, 0, 0)), 300);
  cv::Mat outside = picture.clone();
  outside(area).setTo(cv::Scalar::all(255));
  EXPECT_EQ(CountColour(outside, cv::Scalar::all(255)), 500 * 700);
}

TEST(DrawChart, CutsAtPointsThatAreNoNumbers) {
  cv::Mat whole(400, 500, CV_8UC3, cv::Scalar::all(255));
  cv::Mat cut = whole.clone();
  Chart chart = DiagonalChart();
  chart.series[0].points = {{0, 0}, {1, 1}, {1.5, 1.5}, {2, 2}};
  DrawChart(chart, {0, 0, 500, 400}, &whole);
  chart.series[0].points[1] = {NAN, NAN};
  DrawChart(chart, {0, 0, 500, 400}, &cut);
  EXPECT_LT(CountColour(cut, cv::Scalar(200, 0, 0)), CountColour(whole, cv::Scalar(200, 0, 0)) / 2);
}

TEST(DrawChart, SurvivesEmptyAndConstantSeries) {
  cv::Mat picture(400, 500, CV_8UC3, cv::Scalar::all(255));
  Chart chart = DiagonalChart();
  chart.equal_axes = true;
  chart.series[0].points.clear();
  DrawChart(chart, {0, 0, 500, 400}, &picture);
  chart.series[0].points = {{5, 5}, {5, 5}};
  DrawChart(chart, {0, 0, 500, 400}, &picture);
  chart.y_from_zero = true;
  chart.series[0].points = {{1, 0}, {2, 0}};
  DrawChart(chart, {0, 0, 500, 400}, &picture);
  EXPECT_GT(CountColour(picture, cv::Scalar(200, 0, 0)), 0);
}

}  // namespace
}  // namespace semmap::client
