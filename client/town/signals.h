#pragma once

#include <vector>

#include "client/town/road_network.h"

namespace semmap::town {

enum class Light { kRed, kYellow, kGreen };

// What a junction's controller is told before each step.
struct JunctionDemand {
  std::array<bool, kSides> vehicle_near{};  // somebody comes from this side or waits there
  bool pedestrian_waits = false;
  bool occupied = false;  // a vehicle is between the stop lines, or a pedestrian on a crossing
};

// The traffic lights of all junctions. One side at a time is given green, on demand and in turns; between two
// greens all wait until the junction is empty; pedestrians of all crossings walk together in a phase of their
// own.
class Signals {
 public:
  explicit Signals(const RoadNetwork& network);

  // `demands` by junction id.
  void Step(double seconds, const std::vector<JunctionDemand>& demands);

  Light VehicleLight(int junction, int side) const;
  bool PedestriansMayStart(int junction) const;

 private:
  enum class Stage { kAllRed, kGreen, kYellow };
  static constexpr int kPedestrianPhase = kSides;
  struct Controller {
    bool active = false;
    Stage stage = Stage::kAllRed;
    int phase = 0;  // a side, or kPedestrianPhase
    double elapsed = 0;
  };
  static bool Wants(const JunctionDemand& demand, int phase);
  static void StepOne(double seconds, const JunctionDemand& demand, Controller* controller);

  std::vector<Controller> controllers_;
};

}  // namespace semmap::town
