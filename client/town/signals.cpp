#include "client/town/signals.h"

#include "client/town/street_view.h"

namespace semmap::town {
namespace {
constexpr double kShortestGreen = 3.0;
constexpr double kLongestGreen = 11.0;
constexpr double kPedestrianGreen = 4.0;
constexpr double kYellow = 2.2;
constexpr int kPhases = kSides + 1;
}  // namespace

Signals::Signals(const RoadNetwork& network) {
  for (const Junction& junction : network.junctions()) {
    Controller controller;
    controller.active = HasCrossings(junction);
    controllers_.push_back(controller);
  }
}

void Signals::Step(double seconds, const std::vector<JunctionDemand>& demands) {
  for (size_t i = 0; i < controllers_.size(); ++i) {
    if (controllers_[i].active) StepOne(seconds, demands[i], &controllers_[i]);
  }
}

bool Signals::Wants(const JunctionDemand& demand, int phase) {
  return phase == kPedestrianPhase ? demand.pedestrian_waits
                                   : demand.vehicle_near[static_cast<size_t>(phase)];
}

void Signals::StepOne(double seconds, const JunctionDemand& demand, Controller* controller) {
  controller->elapsed += seconds;
  const auto enter = [controller](Stage stage) {
    controller->stage = stage;
    controller->elapsed = 0;
  };
  if (controller->stage == Stage::kYellow) {
    if (controller->elapsed >= kYellow) enter(Stage::kAllRed);
    return;
  }
  if (controller->stage == Stage::kAllRed) {
    if (demand.occupied) return;
    for (int step = 1; step <= kPhases; ++step) {
      const int phase = (controller->phase + step) % kPhases;
      if (!Wants(demand, phase)) continue;
      controller->phase = phase;
      return enter(Stage::kGreen);
    }
    return;
  }
  if (controller->phase == kPedestrianPhase) {
    if (controller->elapsed >= kPedestrianGreen) enter(Stage::kAllRed);
    return;
  }
  bool others_wait = false;
  for (int phase = 0; phase < kPhases; ++phase)
    others_wait |= phase != controller->phase && Wants(demand, phase);
  const bool still_wanted = Wants(demand, controller->phase);
  if (controller->elapsed < kShortestGreen || !others_wait) return;
  if (!still_wanted || controller->elapsed > kLongestGreen) enter(Stage::kYellow);
}

Light Signals::VehicleLight(int junction, int side) const {
  const Controller& controller = controllers_[static_cast<size_t>(junction)];
  if (!controller.active) return Light::kGreen;
  if (controller.phase != side || controller.stage == Stage::kAllRed) return Light::kRed;
  return controller.stage == Stage::kGreen ? Light::kGreen : Light::kYellow;
}

bool Signals::PedestriansMayStart(int junction) const {
  const Controller& controller = controllers_[static_cast<size_t>(junction)];
  return controller.active && controller.phase == kPedestrianPhase && controller.stage == Stage::kGreen;
}

}  // namespace semmap::town
