#include "server/anchor_fit.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "server/geo_frame.h"
#include "server/gnss_track.h"

namespace semmap::server {
namespace {

// The map's z is the first camera's view, 30 degrees east of north; its y points down.
storage::GeoAnchor Truth(double scale) {
  const double heading = 30 * std::numbers::pi / 180;
  Eigen::Matrix3d rotation;
  rotation.col(0) = Eigen::Vector3d(std::cos(heading), -std::sin(heading), 0);
  rotation.col(1) = -Eigen::Vector3d::UnitZ();
  rotation.col(2) = Eigen::Vector3d(std::sin(heading), std::cos(heading), 0);
  storage::GeoAnchor anchor{48.1, 11.6, 520, {}};
  anchor.enu_from_map = {scale, SE3(rotation, Eigen::Vector3d(3, -2, 1))};
  return anchor;
}

// Fixes of a drive, each as far off as `error_m` says; `position` of every second.
template <typename Position>
std::vector<GnssMatch> Drive(const storage::GeoAnchor& truth, double error_m, Position position) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto error = [&] { return error_m * normal(random); };
  const GeoFrame frame(truth);
  std::vector<GnssMatch> matches;
  for (int second = 0; second < 120; ++second) {
    GnssMatch match;
    match.map_from_camera = SE3(Eigen::Quaterniond::Identity(), position(second) / truth.enu_from_map.scale);
    const Eigen::Vector3d wrong(error(), 2 * error(), error());
    const Eigen::Vector3d p =
        frame.ToGeographic(match.map_from_camera.translation() + wrong / truth.enu_from_map.scale);
    match.fix = {static_cast<uint64_t>(second), p.y(), p.x(), p.z(), std::max(error_m, 0.5)};
    matches.push_back(match);
  }
  return matches;
}

Eigen::Vector3d Bend(int second) {
  const double angle = 0.02 * second;
  return {200 * (1 - std::cos(angle)), 0.5 * std::sin(angle), 200 * std::sin(angle)};
}
Eigen::Vector3d Straight(int second) { return {0.01 * second, 0, 5.0 * second}; }

// Greatest distance between where two anchors put points of the drive's surroundings.
double WorstError(const storage::GeoAnchor& a, const storage::GeoAnchor& b) {
  const GeoFrame first(a);
  const GeoFrame second(b);
  double worst = 0;
  for (const double x : {-50.0, 50.0, 200.0}) {
    for (const double y : {-20.0, 0.0}) {
      for (const double z : {0.0, 200.0}) {
        const Eigen::Vector3d point = Eigen::Vector3d(x, y, z) / a.enu_from_map.scale;
        worst = std::max(worst,
                         (a.enu_from_map.scale * (second.ToMap(first.ToGeographic(point)) - point)).norm());
      }
    }
  }
  return worst;
}

TEST(GeoFrame, ThereAndBack) {
  const GeoFrame frame(Truth(2));
  const Eigen::Vector3d point(100, -5, 300);
  EXPECT_LT((frame.ToMap(frame.ToGeographic(point)) - point).norm(), 1e-6);
  // The origin itself is where enu_from_map puts it: 3 m east, 2 m south, 1 m up.
  const Eigen::Vector3d origin = frame.ToGeographic(Eigen::Vector3d::Zero());
  EXPECT_NEAR(origin.z(), 521, 1e-3);
  EXPECT_GT(origin.x(), 11.6);
  EXPECT_LT(origin.y(), 48.1);
}

TEST(AnchorFit, ExactFixesGiveTheTruth) {
  for (const double scale : {1.0, 7.5}) {
    const storage::GeoAnchor truth = Truth(scale);
    const auto anchor = FitAnchor(Drive(truth, 0, Bend), scale == 1);
    ASSERT_TRUE(anchor.ok()) << anchor.status();
    EXPECT_LT(WorstError(truth, *anchor), 0.05);
    EXPECT_NEAR(anchor->enu_from_map.scale, scale, 1e-4 * scale);
    EXPECT_EQ(anchor->source, storage::GeoAnchor::Source::kFitted);
    EXPECT_LT(anchor->rms_error_m, 0.01);
  }
}

TEST(AnchorFit, ErrorsOfFixesAverageOut) {
  const storage::GeoAnchor truth = Truth(1);
  const auto anchor = FitAnchor(Drive(truth, 2, Bend), true);
  ASSERT_TRUE(anchor.ok()) << anchor.status();
  EXPECT_LT(WorstError(truth, *anchor), 4);
  EXPECT_NEAR(anchor->rms_error_m, 2 * std::numbers::sqrt2, 0.4);
}

// Nothing but the cameras tells how the map leans about a straight road.
TEST(AnchorFit, AStraightRoadIsLevel) {
  for (const double scale : {1.0, 0.2}) {
    const storage::GeoAnchor truth = Truth(scale);
    const auto anchor = FitAnchor(Drive(truth, 1, Straight), scale == 1);
    ASSERT_TRUE(anchor.ok()) << anchor.status();
    EXPECT_LT(WorstError(truth, *anchor), 2) << scale;
  }
}

TEST(AnchorFit, RefusesWhatTellsNothing) {
  const storage::GeoAnchor truth = Truth(1);
  const std::vector<GnssMatch> drive = Drive(truth, 0, Bend);
  EXPECT_TRUE(absl::IsFailedPrecondition(FitAnchor({}, true).status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(FitAnchor(std::span(drive).first(9), true).status()));
  const auto standing = Drive(truth, 2, [](int) { return Eigen::Vector3d(1, 0, 1); });
  EXPECT_TRUE(absl::IsFailedPrecondition(FitAnchor(standing, true).status()));
  // Fixes of another drive.
  std::vector<GnssMatch> mixed = drive;
  for (size_t i = 0; i < mixed.size(); ++i) mixed[i].fix = drive[(i * 37) % drive.size()].fix;
  EXPECT_TRUE(absl::IsFailedPrecondition(FitAnchor(mixed, true).status()));
}

v1::GnssFix FixAt(double latitude) {
  v1::GnssFix fix;
  fix.mutable_position()->set_latitude_deg(latitude);
  fix.set_horizontal_accuracy_m(1);
  return fix;
}

TEST(GnssTrack, KeepsABoundedNumberOfWholeDrives) {
  GnssTrack track;
  for (uint64_t sequence = 1; sequence <= 100'000; ++sequence) track.Add(sequence, FixAt(1));
  EXPECT_GT(track.samples().size(), 1000U);
  EXPECT_LT(track.samples().size(), 5000U);
  EXPECT_EQ(track.samples().front().sequence, 1U);
  EXPECT_GT(track.samples().back().sequence, 99'000U);
  for (size_t i = 1; i < track.samples().size(); ++i) {
    ASSERT_LT(track.samples()[i - 1].sequence, track.samples()[i].sequence);
  }
}

TEST(GnssTrack, PassesOverWhatIsNoFix) {
  GnssTrack track;
  track.Add(1, v1::GnssFix());
  track.Add(2, FixAt(91));
  track.Add(3, FixAt(std::nan("")));
  v1::GnssFix no_accuracy = FixAt(1);
  no_accuracy.set_horizontal_accuracy_m(0);
  track.Add(4, no_accuracy);
  EXPECT_TRUE(track.samples().empty());
  track.Add(5, FixAt(1));
  EXPECT_EQ(track.samples().size(), 1U);
}

}  // namespace
}  // namespace semmap::server
