#include "client/town/simulation.h"

#include <algorithm>
#include <cmath>

namespace semmap::town {
namespace {

constexpr double kPitchPerAcceleration = -0.0045;  // radians for each m/s2
constexpr double kRollPerAcceleration = 0.006;
constexpr double kSuspensionSeconds = 0.25;

// The road's unevenness over the way driven: a few waves that never meet again, metres.
double Bump(double travelled, double shift) {
  return 0.004 * std::sin(travelled / 1.9 + shift) + 0.006 * std::sin(travelled / 4.7 + 2.1 * shift) +
         0.008 * std::sin(travelled / 11.3 + 3.3 * shift);
}

}  // namespace

Simulation::Simulation(const RoadNetwork& network, const Route& route, const Route& crowded,
                       const TrafficConfig& config, uint64_t seed)
    : network_(network),
      vehicles_(network, route, crowded, config.vehicles, seed),
      pedestrians_(network, crowded, config.pedestrians, seed),
      signals_(network),
      last_heading_(vehicles_.ego().heading) {}

void Simulation::Step(double seconds) {
  std::vector<JunctionDemand> demands(network_.junctions().size());
  vehicles_.AddDemand(&demands);
  pedestrians_.AddDemand(&demands);
  signals_.Step(seconds, demands);
  vehicles_.Step(seconds, signals_);
  pedestrians_.Step(seconds, signals_);
  StepSuspension(seconds);
  seconds_ += seconds;
}

void Simulation::StepSuspension(double seconds) {
  const Vehicle& ego = vehicles_.ego();
  const double turn = std::remainder(ego.heading - last_heading_, 2 * 3.14159265358979323846);
  last_heading_ = ego.heading;
  const double sideways = ego.speed * turn / seconds;  // to the left
  const double share = 1 - std::exp(-seconds / kSuspensionSeconds);
  pitch_ += share * (kPitchPerAcceleration * ego.acceleration - pitch_);
  roll_ += share * (kRollPerAcceleration * sideways - roll_);
}

EgoState Simulation::Ego() const {
  const Vehicle& ego = vehicles_.ego();
  EgoState state;
  const double front = Bump(ego.travelled + 1.3, 0.4);
  const double rear = Bump(ego.travelled - 1.3, 0.4);
  state.position = {ego.position.x, ego.position.y, (front + rear) / 2};
  state.heading = ego.heading;
  state.pitch = pitch_ + (rear - front) / 2.6;
  state.roll = roll_ + (Bump(ego.travelled, 1.9) - Bump(ego.travelled, 0.4)) / 1.6;
  state.speed = ego.speed;
  state.travelled = ego.travelled;
  return state;
}

}  // namespace semmap::town
