#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "client/town/pedestrians.h"
#include "client/town/signals.h"
#include "client/town/vehicles.h"

namespace semmap::town {

struct TrafficConfig {
  int vehicles = 20;     // besides the ego vehicle, 0 to 200
  int pedestrians = 10;  // 0 to 500
};

// Where the ego vehicle's body is. Its frame: x forwards, y left, z up, origin on the ground below its
// middle.
struct EgoState {
  glm::dvec3 position{0, 0, 0};
  double heading = 0;  // radians, counter-clockwise from east
  double pitch = 0;    // nose down is positive
  double roll = 0;     // right side down is positive
  double speed = 0;    // m/s
  double travelled = 0;
};

// Everything that moves in the town, stepped from the seed: the state after n steps depends on nothing else.
// The network must outlive it.
class Simulation {
 public:
  // Others are placed where `route` leads.
  Simulation(const RoadNetwork& network, const Route& route, const TrafficConfig& config, uint64_t seed)
      : Simulation(network, route, route, config, seed) {}
  // Others are placed on the streets of `crowded`; only its lanes matter.
  Simulation(const RoadNetwork& network, const Route& route, const Route& crowded,
             const TrafficConfig& config, uint64_t seed);

  // At most a tenth of a second at once.
  void Step(double seconds);

  EgoState Ego() const;
  const Vehicles& vehicles() const { return vehicles_; }
  const Pedestrians& pedestrians() const { return pedestrians_; }
  const Signals& signals() const { return signals_; }
  double seconds() const { return seconds_; }

 private:
  void StepSuspension(double seconds);

  const RoadNetwork& network_;
  Vehicles vehicles_;
  Pedestrians pedestrians_;
  Signals signals_;
  double seconds_ = 0;
  double pitch_ = 0;
  double roll_ = 0;
  double last_heading_ = 0;
};

}  // namespace semmap::town
