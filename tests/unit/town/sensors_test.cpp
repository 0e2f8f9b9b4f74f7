#include "client/town/sensors.h"

#include <cmath>

#include <gtest/gtest.h>

namespace semmap::town {
namespace {

TEST(Geodetic, KnowsTheLengthOfADegree) {
  RigConfig config;
  config.origin_latitude = 60;
  config.origin_longitude = 30;
  config.origin_altitude = 0;
  // One degree at 60 degrees of latitude: 111412 m along the meridian, 55800 m along the parallel.
  const GnssFix north = GeodeticOf(config, {0, 1114.12, 0});
  EXPECT_NEAR(north.latitude, 60.01, 2e-6);
  const GnssFix east = GeodeticOf(config, {558.0, 0, 3});
  EXPECT_NEAR(east.longitude, 30.01, 2e-6);
  EXPECT_NEAR(east.altitude, 3, 1e-9);
}

TEST(VehicleSensors, GnssErrorsHaveTheStatedSize) {
  RigConfig config;
  double sum = 0;
  int fixes = 0;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    VehicleSensors sensors(config, seed);
    for (int frame = 0; frame < 2000; ++frame) {
      const auto fix = sensors.MeasureGnss(frame * 0.05, {0, 0, 0});
      if (!fix.has_value()) continue;
      const double north = (fix->latitude - config.origin_latitude) * 111412;
      sum += north * north;
      ++fixes;
    }
  }
  EXPECT_EQ(fixes, 40 * 500) << "five fixes a second of 20 frames";
  EXPECT_NEAR(std::sqrt(sum / fixes), std::hypot(config.gnss_noise_m, config.gnss_drift_m), 0.35);
}

TEST(VehicleSensors, WheelSpeedIsNearTheTruth) {
  VehicleSensors sensors(RigConfig(), 3);
  double sum = 0;
  for (int i = 0; i < 1000; ++i) sum += sensors.MeasureSpeed(10);
  EXPECT_NEAR(sum / 1000, 10, 0.5);
  EXPECT_NE(sensors.MeasureSpeed(10), 10);
}

TEST(RigConfig, CameraLooksAhead) {
  const RigConfig rig;
  const SE3 vehicle_from_camera = rig.VehicleFromCamera();
  const Eigen::Vector3d ahead = vehicle_from_camera * Eigen::Vector3d(0, 0, 10);
  EXPECT_TRUE(ahead.isApprox(Eigen::Vector3d(10.9, 0, 1.5), 1e-9)) << ahead;
  const Eigen::Vector3d right = vehicle_from_camera * Eigen::Vector3d(1, 0, 0);
  EXPECT_TRUE(right.isApprox(Eigen::Vector3d(0.9, -1, 1.5), 1e-9)) << right;
  EXPECT_NEAR(rig.Intrinsics().fx, 400, 1e-9);
}

TEST(RigConfig, RefusesWhatIsOutOfBounds) {
  auto reader = ConfigReader::FromText("width: 10\nfov_degrees: 100\n", "rig");
  ASSERT_TRUE(reader.ok());
  RigConfig rig;
  rig.Read(*reader);
  const absl::Status status = reader->Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("width"), std::string::npos);
}

TEST(EgoPose, HeadingPitchAndRollTurnTheRightWay) {
  EgoState ego;
  ego.heading = 1.5707963267948966;
  EXPECT_TRUE((TownFromVehicle(ego) * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0, 1, 0), 1e-9));
  ego.heading = 0;
  ego.pitch = 0.1;
  EXPECT_LT((TownFromVehicle(ego) * Eigen::Vector3d(1, 0, 0)).z(), 0) << "nose down";
  ego.pitch = 0;
  ego.roll = 0.1;
  EXPECT_LT((TownFromVehicle(ego) * Eigen::Vector3d(0, -1, 0)).z(), 0) << "right side down";
}

}  // namespace
}  // namespace semmap::town
