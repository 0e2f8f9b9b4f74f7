#include "client/town/vehicles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "client/town/street_view.h"
#include "client/town/vehicle_shapes.h"

namespace semmap::town {
namespace {

constexpr uint64_t kVehicleStream = 111;
constexpr double kSideways = 2.2;      // m/s2 at most in bends
constexpr double kComfortBrake = 2.0;  // m/s2
constexpr double kHardBrake = 3.6;
constexpr double kSurge = 1.7;
constexpr double kHeadway = 1.3;      // s
constexpr double kStandingGap = 2.4;  // m
constexpr double kLookAhead = 60.0;
constexpr double kBendStep = 2.0;
constexpr double kDemandRange = 38.0;
constexpr double kFree = 1e9;

std::vector<double> BendSpeeds(const Path& path) {
  std::vector<double> speeds;
  for (double s = 0; s <= path.length() + kBendStep; s += kBendStep) {
    const double curvature = std::abs(path.CurvatureAt(std::min(s, path.length())));
    speeds.push_back(std::sqrt(kSideways / std::max(curvature, 1e-4)));
  }
  return speeds;
}

}  // namespace

Vehicles::Vehicles(const RoadNetwork& network, const Route& route, const Route& crowded, int others,
                   uint64_t seed)
    : network_(network), random_(seed, kVehicleStream) {
  for (const Lane& lane : network.lanes()) lane_bend_speed_.push_back(BendSpeeds(lane.path));
  for (const Turn& turn : network.turns()) turn_bend_speed_.push_back(BendSpeeds(turn.path));
  PlaceEgo(route);
  PlaceOthers(crowded, others);
}

void Vehicles::PlaceEgo(const Route& route) {
  Vehicle ego;
  ego.cruise = 8.5;
  for (size_t i = 0; i < route.lanes.size(); ++i) {
    ego.plan.push_back({false, route.lanes[i]});
    if (i < route.turns.size()) ego.plan.push_back({true, route.turns[i]});
  }
  ego.s = route.start_on_lane;
  Extend(&ego);
  PlaceBody(&ego);
  vehicles_.push_back(std::move(ego));
}

bool Vehicles::HasRoom(int lane, double s, double length) const {
  return std::none_of(vehicles_.begin(), vehicles_.end(), [&](const Vehicle& other) {
    return other.plan.front() == Segment{false, lane} &&
           std::abs(other.s - s) < (other.length + length) / 2 + 5;
  });
}

void Vehicles::PlaceOthers(const Route& route, int count) {
  // Where the ego vehicle will see them: on its way and on the other side of its streets, then anywhere.
  std::vector<int> lanes;
  for (const int lane : route.lanes) {
    lanes.push_back(lane);
    lanes.push_back(lane ^ 1);  // lanes come in pairs, one street's two directions
  }
  for (int attempt = 0; attempt < 200 * count && static_cast<int>(vehicles_.size()) <= count; ++attempt) {
    const bool near = random_.Chance(0.8);
    const int lane = near ? random_.Pick(lanes) : random_.Below(static_cast<int>(network_.lanes().size()));
    Vehicle vehicle;
    vehicle.kind = random_.Chance(0.06) ? 6 : random_.Chance(0.15) ? 5 : random_.Below(5);
    vehicle.look = random_.Next();
    vehicle.length = ShapeOf(vehicle.kind).length;
    vehicle.width = ShapeOf(vehicle.kind).width;
    vehicle.cruise = random_.Uniform(6.5, 9.5);
    const double room = network_.lanes()[static_cast<size_t>(lane)].path.length();
    const double s =
        random_.Uniform(vehicle.length / 2 + 3, room - kStopBeforeLaneEnd - vehicle.length / 2 - 1);
    if (!HasRoom(lane, s, vehicle.length)) continue;
    vehicle.plan = {{false, lane}};
    vehicle.s = s;
    vehicle.speed = random_.Uniform(0, 5);
    Extend(&vehicle);
    PlaceBody(&vehicle);
    vehicles_.push_back(std::move(vehicle));
  }
}

const Path& Vehicles::PathOf(const Segment& segment) const {
  const auto id = static_cast<size_t>(segment.id);
  return segment.turn ? network_.turns()[id].path : network_.lanes()[id].path;
}

void Vehicles::Extend(Vehicle* vehicle) {
  while (vehicle->plan.size() < 5) {
    const Segment last = vehicle->plan.back();
    if (last.turn) {
      vehicle->plan.push_back({false, network_.turns()[static_cast<size_t>(last.id)].to_lane});
    } else {
      vehicle->plan.push_back({true, random_.Pick(network_.TurnsFrom(last.id))});
    }
  }
}

const Path* Vehicles::SegmentBehind(const Vehicle& vehicle) const {
  const Segment& at = vehicle.plan.front();
  if (at.turn)
    return &network_.lanes()[static_cast<size_t>(network_.turns()[static_cast<size_t>(at.id)].from_lane)]
                .path;
  return vehicle.last_turn < 0 ? nullptr : &network_.turns()[static_cast<size_t>(vehicle.last_turn)].path;
}

glm::dvec2 Vehicles::PointOnWay(const Vehicle& vehicle, double ahead) const {
  double s = vehicle.s + ahead;
  const Path& first = PathOf(vehicle.plan.front());
  if (s < 0) {
    const Path* before = SegmentBehind(vehicle);
    if (before != nullptr) return before->PointAt(before->length() + s);
    return first.PointAt(0) + first.TangentAt(0) * s;
  }
  for (const Segment& segment : vehicle.plan) {
    const Path& path = PathOf(segment);
    if (s <= path.length()) return path.PointAt(s);
    s -= path.length();
  }
  return PathOf(vehicle.plan.back()).PointAt(s);
}

void Vehicles::PlaceBody(Vehicle* vehicle) const {
  const double half_base = vehicle->length * 0.3;
  const glm::dvec2 front = PointOnWay(*vehicle, half_base);
  const glm::dvec2 rear = PointOnWay(*vehicle, -half_base);
  vehicle->position = (front + rear) * 0.5;
  vehicle->heading = std::atan2(front.y - rear.y, front.x - rear.x);
}

double Vehicles::BendSpeed(const Vehicle& vehicle) const {
  double limit = vehicle.cruise;
  double offset = -vehicle.s;
  for (const Segment& segment : vehicle.plan) {
    const auto& speeds =
        (segment.turn ? turn_bend_speed_ : lane_bend_speed_)[static_cast<size_t>(segment.id)];
    for (size_t i = 0; i < speeds.size(); ++i) {
      const double distance = offset + static_cast<double>(i) * kBendStep;
      if (distance < -kBendStep) continue;
      if (distance > kLookAhead) return limit;
      limit = std::min(limit, std::sqrt(speeds[i] * speeds[i] + 2 * 1.4 * std::max(0.0, distance - 2)));
    }
    offset += PathOf(segment).length();
  }
  return limit;
}

Vehicles::Leader Vehicles::FindLeader(size_t index) const {
  const Vehicle& me = vehicles_[index];
  Leader leader;
  const auto consider = [&](const Vehicle& other, double distance) {
    const double gap = distance - (me.length + other.length) / 2;
    if (distance > 0 && gap < leader.gap) leader = {gap, other.speed};
  };
  double offset = -me.s;
  for (size_t k = 0; k < me.plan.size() && offset < kLookAhead; ++k) {
    const Segment& segment = me.plan[k];
    for (size_t j = 0; j < vehicles_.size(); ++j) {
      if (j == index) continue;
      const Vehicle& other = vehicles_[j];
      const Segment& at = other.plan.front();
      if (at == segment) {
        consider(other, offset + other.s);
      } else if (segment.turn && at.turn &&
                 network_.turns()[static_cast<size_t>(at.id)].from_lane ==
                     network_.turns()[static_cast<size_t>(segment.id)].from_lane) {
        // Just parted from my way: its tail still is on it.
        if (other.s < 9 + other.length / 2) consider(other, offset + other.s);
      }
    }
    offset += PathOf(segment).length();
  }
  return leader;
}

int Vehicles::SideOfLane(const Lane& lane) const {
  const Junction& junction = network_.junctions()[static_cast<size_t>(lane.to)];
  for (int side = 0; side < kSides; ++side) {
    if (junction.street[static_cast<size_t>(side)] == lane.street) return side;
  }
  return 0;
}

bool Vehicles::PastStopLine(const Vehicle& vehicle) const {
  const Segment& at = vehicle.plan.front();
  return !at.turn && vehicle.s + vehicle.length / 2 > PathOf(at).length() - kStopBeforeLaneEnd + 0.6;
}

Vehicles::Occupancy Vehicles::OccupancyOf(const Vehicle& vehicle) const {
  const Segment& at = vehicle.plan.front();
  if (at.turn) {
    const Turn& turn = network_.turns()[static_cast<size_t>(at.id)];
    return {turn.junction, turn.from_side};
  }
  const Lane& lane = network_.lanes()[static_cast<size_t>(at.id)];
  if (PastStopLine(vehicle)) return {lane.to, SideOfLane(lane)};
  if (vehicle.s - vehicle.length / 2 < kCrossingTo + 0.5 && vehicle.last_turn >= 0) {
    const Turn& turn = network_.turns()[static_cast<size_t>(vehicle.last_turn)];
    return {turn.junction, turn.from_side};
  }
  return {};
}

bool Vehicles::MayEnter(size_t index, const Turn& turn) const {
  const Vehicle& me = vehicles_[index];
  for (size_t j = 0; j < vehicles_.size(); ++j) {
    if (j == index) continue;
    const Vehicle& other = vehicles_[j];
    const Occupancy there = OccupancyOf(other);
    if (there.junction == turn.junction && there.side != turn.from_side) return false;
    // Room behind the junction: nobody stands in the first metres of the lane that I go to.
    const bool on_my_exit = other.plan.front() == Segment{false, turn.to_lane};
    const double needed = kCrossingTo + me.length + other.length / 2 + 3;
    if (on_my_exit && other.s < needed && other.speed < 2.5) return false;
    // Somebody of my side is in the junction and goes where I go: count his place as taken.
    const bool same_target =
        other.plan.front().turn &&
        network_.turns()[static_cast<size_t>(other.plan.front().id)].to_lane == turn.to_lane;
    if (same_target && other.speed < 1.0) return false;
  }
  return true;
}

double Vehicles::GapToStop(size_t index, const Signals& signals) const {
  const Vehicle& me = vehicles_[index];
  if (me.plan.front().turn || PastStopLine(me)) return kFree;
  const Lane& lane = network_.lanes()[static_cast<size_t>(me.plan.front().id)];
  const Junction& junction = network_.junctions()[static_cast<size_t>(lane.to)];
  if (!HasCrossings(junction)) return kFree;
  const double gap = lane.path.length() - kStopBeforeLaneEnd - me.s - me.length / 2;
  if (gap > kLookAhead) return kFree;
  const Turn& turn = network_.turns()[static_cast<size_t>(me.plan[1].id)];
  const Light light = signals.VehicleLight(junction.id, turn.from_side);
  const double to_stop = me.speed * me.speed / (2 * kHardBrake);
  if (light == Light::kYellow && to_stop > gap) return kFree;  // too late to stop in comfort
  // The kerb-side light turns green as one comes near; do not brake for it from afar.
  if (light == Light::kRed && gap > std::max(20.0, 2.2 * to_stop)) return kFree;
  if (light == Light::kGreen && MayEnter(index, turn)) return kFree;
  return gap;
}

double Vehicles::Acceleration(size_t index, const Signals& signals) const {
  const Vehicle& me = vehicles_[index];
  const double wished = std::max(0.5, BendSpeed(me));
  const double ratio = me.speed / wished;
  double acceleration = kSurge * (1 - ratio * ratio * ratio * ratio);
  const auto keep_off = [&](double gap, double other_speed, double standing) {
    const double closing = me.speed * (me.speed - other_speed) / (2 * std::sqrt(kSurge * kComfortBrake));
    const double wanted = standing + std::max(0.0, me.speed * kHeadway + closing);
    const double free_share = 1 - ratio * ratio * ratio * ratio;
    const double share = wanted / std::max(gap, 0.1);
    acceleration = std::min(acceleration, kSurge * (free_share - share * share));
  };
  const Leader leader = FindLeader(index);
  if (leader.gap < kLookAhead) keep_off(leader.gap, leader.speed, kStandingGap);
  const double stop = GapToStop(index, signals);
  if (stop < kLookAhead) keep_off(stop + 0.8, 0, 0.9);
  return std::clamp(acceleration, -8.0, kSurge);
}

void Vehicles::Step(double seconds, const Signals& signals) {
  std::vector<double> wanted(vehicles_.size());
  for (size_t i = 0; i < vehicles_.size(); ++i) wanted[i] = Acceleration(i, signals);
  for (size_t i = 0; i < vehicles_.size(); ++i) {
    Vehicle& vehicle = vehicles_[i];
    // Feet are not instantaneous, on the brake faster than on the throttle.
    const double change = wanted[i] - vehicle.acceleration;
    vehicle.acceleration += std::clamp(change, -14.0 * seconds, 4.0 * seconds);
    const double before = vehicle.speed;
    vehicle.speed = std::max(0.0, vehicle.speed + vehicle.acceleration * seconds);
    if (vehicle.speed == 0.0) vehicle.acceleration = std::max(0.0, vehicle.acceleration);
    const double moved = (before + vehicle.speed) / 2 * seconds;
    vehicle.s += moved;
    vehicle.travelled += moved;
    while (vehicle.s > PathOf(vehicle.plan.front()).length()) {
      vehicle.s -= PathOf(vehicle.plan.front()).length();
      vehicle.last_turn = vehicle.plan.front().turn ? vehicle.plan.front().id : -1;
      vehicle.plan.pop_front();
      Extend(&vehicle);
    }
    PlaceBody(&vehicle);
  }
}

void Vehicles::AddDemand(std::vector<JunctionDemand>* demands) const {
  for (const Vehicle& vehicle : vehicles_) {
    const Occupancy inside = OccupancyOf(vehicle);
    if (inside.junction >= 0) (*demands)[static_cast<size_t>(inside.junction)].occupied = true;
    if (vehicle.plan.front().turn || PastStopLine(vehicle)) continue;
    const Lane& lane = network_.lanes()[static_cast<size_t>(vehicle.plan.front().id)];
    const double left = lane.path.length() - vehicle.s;
    if (left > kDemandRange) continue;
    (*demands)[static_cast<size_t>(lane.to)].vehicle_near[static_cast<size_t>(SideOfLane(lane))] = true;
  }
}

}  // namespace semmap::town
