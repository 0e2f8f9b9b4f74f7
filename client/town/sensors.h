#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "client/town/random.h"
#include "client/town/rig.h"
#include "client/town/simulation.h"

namespace semmap::town {

struct GnssFix {
  double latitude = 0;  // degrees, WGS84
  double longitude = 0;
  double altitude = 0;  // metres
  double deviation_m = 0;
};

// Wheel speed and satellite fixes with the errors of real ones, drawn from a seed.
class VehicleSensors {
 public:
  VehicleSensors(const RigConfig& config, uint64_t seed);

  // To be called once a frame, in order.
  double MeasureSpeed(double true_speed);
  // Only every so many frames has a fix. `east_north_up` in the town's frame.
  std::optional<GnssFix> MeasureGnss(double seconds, const Eigen::Vector3d& east_north_up);

 private:
  RigConfig config_;
  Random random_;
  double speed_scale_;
  Eigen::Vector3d drift_{0, 0, 0};
  double next_fix_ = 0;
};

// Degrees and metres of a point of the town's frame (east, north, up around the rig's origin); the earth
// taken as the ellipsoid's osculating sphere there, which is good to a millimetre over a town.
GnssFix GeodeticOf(const RigConfig& config, const Eigen::Vector3d& east_north_up);

// town_from_vehicle of the ego vehicle's body.
SE3 TownFromVehicle(const EgoState& ego);

}  // namespace semmap::town
