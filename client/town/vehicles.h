#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "client/town/random.h"
#include "client/town/road_network.h"
#include "client/town/signals.h"

namespace semmap::town {

// A piece of a vehicle's way: a lane or a turn.
struct Segment {
  bool turn = false;
  int id = 0;
  bool operator==(const Segment&) const = default;
};

struct Vehicle {
  int kind = 0;  // ShapeOf(kind)
  uint64_t look = 0;
  double length = 4.4;
  double width = 1.8;
  double cruise = 9.0;       // m/s
  std::deque<Segment> plan;  // plan[0] is where its middle is
  double s = 0;              // along plan[0]
  int last_turn = -1;        // the turn that led to the present lane; -1: none yet
  double speed = 0;
  double acceleration = 0;
  double travelled = 0;
  // Where the body is: middle and heading, from the axles' places on the way.
  glm::dvec2 position{0, 0};
  double heading = 0;
};

// All vehicles of a town. Follow the leader by the intelligent driver model (Treiber, Hennecke, Helbing
// 2000), slow down for bends, obey the lights and enter a junction only while everybody in it came from the
// same side and there is room behind it. Index 0 is the ego vehicle, which follows its route; the others turn
// where they like.
class Vehicles {
 public:
  Vehicles(const RoadNetwork& network, const Route& route, const Route& crowded, int others, uint64_t seed);

  void Step(double seconds, const Signals& signals);
  const std::vector<Vehicle>& all() const { return vehicles_; }
  const Vehicle& ego() const { return vehicles_.front(); }
  // Adds what the vehicles ask of the lights.
  void AddDemand(std::vector<JunctionDemand>* demands) const;

 private:
  void PlaceEgo(const Route& route);
  void PlaceOthers(const Route& route, int count);
  bool HasRoom(int lane, double s, double length) const;
  const Path& PathOf(const Segment& segment) const;
  void Extend(Vehicle* vehicle);
  // A point of the vehicle's way, `ahead` metres from its middle; may lie behind.
  glm::dvec2 PointOnWay(const Vehicle& vehicle, double ahead) const;
  // The lane or turn that the vehicle came from; null if it has not left its first.
  const Path* SegmentBehind(const Vehicle& vehicle) const;
  void PlaceBody(Vehicle* vehicle) const;

  double Acceleration(size_t index, const Signals& signals) const;
  double BendSpeed(const Vehicle& vehicle) const;
  // Free metres to the next vehicle on the way and its speed.
  struct Leader {
    double gap = 1e9;
    double speed = 0;
  };
  Leader FindLeader(size_t index) const;
  // Metres from the bumper to a stop line at which the vehicle has to wait; large when it may go on.
  double GapToStop(size_t index, const Signals& signals) const;
  bool MayEnter(size_t index, const Turn& turn) const;
  bool PastStopLine(const Vehicle& vehicle) const;
  // The junction that the vehicle stands in, and the side it came from; -1 outside.
  struct Occupancy {
    int junction = -1;
    int side = 0;
  };
  Occupancy OccupancyOf(const Vehicle& vehicle) const;
  int SideOfLane(const Lane& lane) const;

  const RoadNetwork& network_;
  std::vector<Vehicle> vehicles_;
  std::vector<std::vector<double>> lane_bend_speed_;
  std::vector<std::vector<double>> turn_bend_speed_;
  Random random_;
};

// How far before the end of a lane the stop line is, measured to the waiting bumper.
inline constexpr double kStopBeforeLaneEnd = 5.9;

}  // namespace semmap::town
