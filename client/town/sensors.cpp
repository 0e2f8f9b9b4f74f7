#include "client/town/sensors.h"

#include <cmath>
#include <numbers>

namespace semmap::town {
namespace {
constexpr uint64_t kSensorStream = 131;
constexpr double kDriftSeconds = 60;
constexpr double kDegrees = 180 / std::numbers::pi;
}  // namespace

VehicleSensors::VehicleSensors(const RigConfig& config, uint64_t seed)
    : config_(config),
      random_(seed, kSensorStream),
      speed_scale_(1 + config.speed_scale_error * random_.Normal()) {
  drift_ = Eigen::Vector3d(random_.Normal(), random_.Normal(), random_.Normal()) * config.gnss_drift_m;
}

double VehicleSensors::MeasureSpeed(double true_speed) {
  return true_speed * speed_scale_ * (1 + config_.speed_noise * random_.Normal());
}

std::optional<GnssFix> VehicleSensors::MeasureGnss(double seconds, const Eigen::Vector3d& east_north_up) {
  if (seconds + 1e-9 < next_fix_) return std::nullopt;
  next_fix_ += 1 / config_.gnss_hertz;
  // An Ornstein-Uhlenbeck walk: it wanders within gnss_drift_m and forgets in a minute.
  const double keep = std::exp(-1 / (config_.gnss_hertz * kDriftSeconds));
  Eigen::Vector3d error = drift_ * keep;
  for (int i = 0; i < 3; ++i) {
    drift_[i] = error[i] + config_.gnss_drift_m * std::sqrt(1 - keep * keep) * random_.Normal();
    error[i] = drift_[i] + (i == 2 ? 2.0 : 1.0) * config_.gnss_noise_m * random_.Normal();
  }
  GnssFix fix = GeodeticOf(config_, east_north_up + error);
  fix.deviation_m = std::hypot(config_.gnss_noise_m, config_.gnss_drift_m);
  return fix;
}

GnssFix GeodeticOf(const RigConfig& config, const Eigen::Vector3d& east_north_up) {
  constexpr double kEquator = 6378137.0;  // WGS84
  constexpr double kFlattening = 1 / 298.257223563;
  constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);
  const double sine = std::sin(config.origin_latitude / kDegrees);
  const double w2 = 1 - kEccentricity2 * sine * sine;
  const double meridian = kEquator * (1 - kEccentricity2) / (w2 * std::sqrt(w2));
  const double normal = kEquator / std::sqrt(w2);
  const double parallel = (normal + config.origin_altitude) * std::cos(config.origin_latitude / kDegrees);
  GnssFix fix;
  fix.latitude = config.origin_latitude + east_north_up.y() / (meridian + config.origin_altitude) * kDegrees;
  fix.longitude = config.origin_longitude + east_north_up.x() / parallel * kDegrees;
  fix.altitude = config.origin_altitude + east_north_up.z();
  return fix;
}

SE3 TownFromVehicle(const EgoState& ego) {
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(ego.heading, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(ego.pitch, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(ego.roll, Eigen::Vector3d::UnitX());
  return {rotation, Eigen::Vector3d(ego.position.x, ego.position.y, ego.position.z)};
}

}  // namespace semmap::town
