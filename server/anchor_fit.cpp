#include "server/anchor_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "server/geo_frame.h"
#include "slam/common/status_macros.h"
#include "slam/geometry/alignment.h"

namespace semmap::server {
namespace {

constexpr size_t kMinMatches = 10;
// The vehicle must have gone this many times as far as a fix is wrong; across the main direction, for the fit
// to tell how the map leans.
constexpr double kMinSpread = 5;
constexpr double kMinSpreadAcross = 10;
// More than this many times the stated accuracy, and the fixes are of something else.
constexpr double kMaxError = 5;

using Points = std::vector<Eigen::Vector3d>;

Eigen::Vector3d MeanOf(const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

// Standard deviations of the horizontal positions across and along their main direction.
Eigen::Vector2d SpreadOf(const Points& enu) {
  const Eigen::Vector3d mean = MeanOf(enu);
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector3d& point : enu) {
    const Eigen::Vector2d offset = (point - mean).head<2>();
    covariance += offset * offset.transpose();
  }
  covariance /= static_cast<double>(enu.size());
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues().cwiseMax(0).cwiseSqrt();
}

// Cameras look along the road: on average their y axis points down.
Eigen::Quaterniond LevelFromMap(std::span<const GnssMatch> matches) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const GnssMatch& match : matches) up -= match.map_from_camera.rotation() * Eigen::Vector3d::UnitY();
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
}

// Rotation about the vertical, scale and translation: in the plane a rotation with scale is one complex
// number.
Sim3 FitLevel(const Points& level, const Points& enu, bool with_scale) {
  const Eigen::Vector3d level_mean = MeanOf(level);
  const Eigen::Vector3d enu_mean = MeanOf(enu);
  double dot = 0;
  double cross = 0;
  double square = 0;
  for (size_t i = 0; i < level.size(); ++i) {
    const Eigen::Vector3d a = level[i] - level_mean;
    const Eigen::Vector3d b = enu[i] - enu_mean;
    dot += a.head<2>().dot(b.head<2>());
    cross += a.x() * b.y() - a.y() * b.x();
    square += a.head<2>().squaredNorm();
  }
  Sim3 result;
  if (with_scale && square > 0) result.scale = std::hypot(dot, cross) / square;
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(std::atan2(cross, dot), Eigen::Vector3d::UnitZ()));
  result.rigid = SE3(rotation, enu_mean - result.scale * (rotation * level_mean));
  return result;
}

double HorizontalRms(const Sim3& enu_from_map, const Points& map, const Points& enu) {
  double sum = 0;
  for (size_t i = 0; i < map.size(); ++i) sum += (enu_from_map * map[i] - enu[i]).head<2>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(map.size()));
}

double MedianAccuracy(std::span<const GnssMatch> matches) {
  std::vector<double> accuracies;
  for (const GnssMatch& match : matches) accuracies.push_back(match.fix.horizontal_accuracy_m);
  const auto middle = accuracies.begin() + static_cast<std::ptrdiff_t>(accuracies.size() / 2);
  std::nth_element(accuracies.begin(), middle, accuracies.end());
  return *middle;
}

absl::StatusOr<Sim3> Fit(std::span<const GnssMatch> matches, const Points& map, const Points& enu,
                         const Eigen::Vector2d& spread, double accuracy, bool scale_known) {
  if (spread.x() >= kMinSpreadAcross * accuracy) return AlignPoints(map, enu, !scale_known);
  const Sim3 level_from_map{1, SE3(LevelFromMap(matches), Eigen::Vector3d::Zero())};
  Points level;
  for (const Eigen::Vector3d& point : map) level.push_back(level_from_map * point);
  return FitLevel(level, enu, !scale_known) * level_from_map;
}

}  // namespace

absl::StatusOr<storage::GeoAnchor> FitAnchor(std::span<const GnssMatch> matches, bool scale_known) {
  if (matches.size() < kMinMatches) return absl::FailedPreconditionError("too few fixes");
  storage::GeoAnchor anchor;
  anchor.latitude_deg = matches.front().fix.latitude_deg;
  anchor.longitude_deg = matches.front().fix.longitude_deg;
  anchor.altitude_m = matches.front().fix.altitude_m;
  anchor.source = storage::GeoAnchor::Source::kFitted;
  const GeoFrame origin(anchor);
  Points map;
  Points enu;
  for (const GnssMatch& match : matches) {
    map.push_back(match.map_from_camera.translation());
    enu.push_back(origin.ToMap({match.fix.longitude_deg, match.fix.latitude_deg, match.fix.altitude_m}));
  }
  const double accuracy = MedianAccuracy(matches);
  const Eigen::Vector2d spread = SpreadOf(enu);
  if (!(spread.y() >= kMinSpread * accuracy)) {
    return absl::FailedPreconditionError("the vehicle has not gone far enough for the accuracy of its fixes");
  }
  SEMMAP_ASSIGN_OR_RETURN(anchor.enu_from_map, Fit(matches, map, enu, spread, accuracy, scale_known));
  anchor.rms_error_m = HorizontalRms(anchor.enu_from_map, map, enu);
  if (anchor.rms_error_m <= kMaxError * accuracy && anchor.enu_from_map.scale > 0) return anchor;
  return absl::FailedPreconditionError("the fixes do not lie where the vehicle drove");
}

}  // namespace semmap::server
