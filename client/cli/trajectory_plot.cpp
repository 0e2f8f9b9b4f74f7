#include "client/cli/trajectory_plot.h"

#include <array>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/chart.h"
#include "client/cli/write_png.h"
#include "slam/evaluation/mape.h"
#include "slam/evaluation/statistics.h"

namespace semmap::client {
namespace {

const cv::Scalar kReferenceColour(180, 119, 31);
const cv::Scalar kEstimateColour(14, 127, 255);
const cv::Scalar kErrorColour(40, 39, 214);
const cv::Scalar kMeanColour(120, 120, 120);
const cv::Scalar kStartColour(44, 160, 44);
constexpr int kWidth = 1200;
constexpr int kMapHeight = 820;
constexpr int kErrorHeight = 380;

// Poses further apart than this many usual intervals are not joined by a line: nothing is known in between.
constexpr double kGapInIntervals = 10;

// Seconds between poses beyond which there is a gap; infinite without times.
double GapOf(const std::vector<TimestampNs>& times) {
  std::vector<double> intervals;
  for (size_t i = 1; i < times.size(); ++i) intervals.push_back(ToSeconds(times[i] - times[i - 1]));
  const double median = Percentile(intervals, 0.5);
  return median > 0 ? kGapInIntervals * median : INFINITY;
}

// Cuts the line (by a point that is no number) wherever time jumps.
std::vector<cv::Point2d> CutAtGaps(const std::vector<cv::Point2d>& points,
                                   const std::vector<TimestampNs>& times) {
  const double gap_s = GapOf(times);
  std::vector<cv::Point2d> cut;
  for (size_t i = 0; i < points.size(); ++i) {
    if (i > 0 && ToSeconds(times[i] - times[i - 1]) > gap_s) cut.emplace_back(NAN, NAN);
    cut.push_back(points[i]);
  }
  return cut;
}

template <typename Transform>
std::vector<cv::Point2d> Project(const Trajectory& trajectory, const std::array<int, 2>& axes,
                                 Transform transform) {
  std::vector<cv::Point2d> points;
  std::vector<TimestampNs> times;
  for (const StampedPose& pose : trajectory.poses) {
    const Eigen::Vector3d position = transform(pose.map_from_camera.translation());
    points.emplace_back(position[axes[0]], position[axes[1]]);
    times.push_back(pose.timestamp);
  }
  return CutAtGaps(points, times);
}

Chart MapChart(const TrajectoryPlot& plot) {
  const std::array<int, 2> axes = GroundAxes(plot.pairs);
  const char* names = "xyz";
  Chart chart;
  chart.title = plot.title;
  chart.x_label = absl::StrFormat("%c [m]", names[axes[0]]);
  chart.y_label = absl::StrFormat("%c [m]", names[axes[1]]);
  chart.equal_axes = true;
  const auto same = [](const Eigen::Vector3d& p) { return p; };
  const auto aligned = [&plot](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(plot.reference_from_estimate * p);
  };
  chart.series = {{"reference", kReferenceColour, Project(plot.reference, axes, same), 3, false},
                  {"estimate (aligned)", kEstimateColour, Project(plot.estimate, axes, aligned), 2, false}};
  if (!chart.series[1].points.empty()) {
    chart.markers = {{"start", kStartColour, chart.series[1].points.front()},
                     {"end", kErrorColour, chart.series[1].points.back()}};
  }
  return chart;
}

Chart ErrorChart(const TrajectoryPlot& plot) {
  Chart chart;
  chart.title = "Position error";
  chart.x_label = plot.by_time ? "time since the first pose [s]" : "frame";
  chart.y_label = "error [m]";
  chart.y_from_zero = true;
  const ErrorStatistics statistics = Summarize(plot.errors_m);
  ChartSeries error{"error", kErrorColour, {}, 1, false};
  std::vector<TimestampNs> times;
  ChartSeries rmse{absl::StrFormat("RMSE %.4g m", statistics.rmse), kReferenceColour, {}, 2, true};
  ChartSeries median{absl::StrFormat("median %.4g m", statistics.median), kMeanColour, {}, 2, true};
  for (size_t i = 0; i < plot.pairs.size() && i < plot.errors_m.size(); ++i) {
    const double x = plot.by_time ? ToSeconds(plot.pairs[i].timestamp - plot.pairs.front().timestamp)
                                  : static_cast<double>(plot.pairs[i].estimate_index);
    error.points.emplace_back(x, plot.errors_m[i]);
    times.push_back(plot.pairs[i].timestamp);
  }
  if (!error.points.empty()) {
    for (const double x : {error.points.front().x, error.points.back().x}) {
      rmse.points.emplace_back(x, statistics.rmse);
      median.points.emplace_back(x, statistics.median);
    }
  }
  error.points = CutAtGaps(error.points, times);
  chart.series = {std::move(error), std::move(rmse), std::move(median)};
  return chart;
}

}  // namespace

absl::Status WriteTrajectoryPlot(const std::string& path, const TrajectoryPlot& plot) {
  try {
    cv::Mat picture(kMapHeight + kErrorHeight, kWidth, CV_8UC3, cv::Scalar::all(255));
    DrawChart(MapChart(plot), {0, 0, kWidth, kMapHeight}, &picture);
    DrawChart(ErrorChart(plot), {0, kMapHeight, kWidth, kErrorHeight}, &picture);
    return WritePng(path, picture);
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("the plot cannot be drawn: ", error.what()));
  }
}

}  // namespace semmap::client
