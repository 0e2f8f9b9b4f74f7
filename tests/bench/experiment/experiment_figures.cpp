#include "tests/bench/experiment/experiment_figures.h"

#include <array>
#include <cmath>

#include "client/cli/chart.h"
#include "tests/bench/experiment/files.h"

namespace semmap::bench {
namespace {

constexpr int kWidth = 1000;
constexpr int kMapHeight = 700;
constexpr int kErrorHeight = 360;
const cv::Scalar kTruthColour(180, 119, 31);
const std::array<cv::Scalar, 5> kColours = {cv::Scalar(14, 127, 255), cv::Scalar(44, 160, 44),
                                            cv::Scalar(189, 103, 148), cv::Scalar(40, 39, 214),
                                            cv::Scalar(75, 86, 140)};

// Lines are cut where frames are missing.
std::vector<cv::Point2d> CutAtGaps(const std::vector<int>& frames, const std::vector<cv::Point2d>& points) {
  constexpr int kGap = 20;
  std::vector<cv::Point2d> cut;
  for (size_t i = 0; i < points.size(); ++i) {
    if (i > 0 && frames[i] - frames[i - 1] > kGap) cut.emplace_back(NAN, NAN);
    cut.push_back(points[i]);
  }
  return cut;
}

client::ChartSeries MapLine(const VariantResult& result, const cv::Scalar& colour) {
  std::vector<cv::Point2d> points;
  for (const Eigen::Vector2d& position : result.estimate) points.emplace_back(position.x(), position.y());
  return {result.variant, colour, CutAtGaps(result.frame, points), 2, false};
}

client::ChartSeries ErrorLine(const VariantResult& result, const cv::Scalar& colour) {
  std::vector<cv::Point2d> points;
  for (size_t i = 0; i < result.error_m.size(); ++i) points.emplace_back(result.frame[i], result.error_m[i]);
  return {result.variant, colour, CutAtGaps(result.frame, points), 2, false};
}

}  // namespace

absl::Status WriteFigures(const std::string& path, const std::string& title, const Trajectory& truth,
                          const std::vector<const VariantResult*>& results) {
  client::Chart map;
  map.title = title;
  map.x_label = "east [m]";
  map.y_label = "north [m]";
  map.equal_axes = true;
  map.series.push_back({"truth", kTruthColour, {}, 3, false});
  for (const StampedPose& pose : truth.poses) {
    const Eigen::Vector3d& position = pose.map_from_camera.translation();
    map.series.front().points.emplace_back(position.x(), position.y());
  }
  client::Chart errors;
  errors.title = "Position error";
  errors.x_label = "frame";
  errors.y_label = "error [m]";
  errors.y_from_zero = true;
  for (size_t i = 0; i < results.size(); ++i) {
    const cv::Scalar& colour = kColours[i % kColours.size()];
    map.series.push_back(MapLine(*results[i], colour));
    errors.series.push_back(ErrorLine(*results[i], colour));
  }
  try {
    cv::Mat picture(kMapHeight + kErrorHeight, kWidth, CV_8UC3, cv::Scalar::all(255));
    client::DrawChart(map, {0, 0, kWidth, kMapHeight}, &picture);
    client::DrawChart(errors, {0, kMapHeight, kWidth, kErrorHeight}, &picture);
    return WriteImage(path, picture, {});
  } catch (const cv::Exception& error) {
    return absl::InternalError(std::string("the figures cannot be drawn: ") + error.what());
  }
}

}  // namespace semmap::bench
