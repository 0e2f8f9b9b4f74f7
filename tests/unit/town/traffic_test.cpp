#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "client/town/simulation.h"
#include "client/town/street_view.h"

namespace semmap::town {
namespace {

constexpr double kStep = 0.05;

std::array<glm::dvec2, 4> CornersOf(const Vehicle& vehicle) {
  const glm::dvec2 forward =
      glm::dvec2(std::cos(vehicle.heading), std::sin(vehicle.heading)) * (vehicle.length / 2);
  const glm::dvec2 left = glm::normalize(glm::dvec2(-forward.y, forward.x)) * (vehicle.width / 2);
  const glm::dvec2& at = vehicle.position;
  return {at + forward + left, at + forward - left, at - forward - left, at - forward + left};
}

// Whether some line along one of a's sides parts the two rectangles.
bool Parted(const std::array<glm::dvec2, 4>& a, const std::array<glm::dvec2, 4>& b) {
  for (const glm::dvec2 axis : {a[0] - a[1], a[1] - a[2]}) {
    double a_low = 1e9, a_high = -1e9, b_low = 1e9, b_high = -1e9;
    for (size_t i = 0; i < 4; ++i) {
      a_low = std::min(a_low, glm::dot(a[i], axis));
      a_high = std::max(a_high, glm::dot(a[i], axis));
      b_low = std::min(b_low, glm::dot(b[i], axis));
      b_high = std::max(b_high, glm::dot(b[i], axis));
    }
    if (a_high < b_low || b_high < a_low) return true;
  }
  return false;
}

bool Overlap(const Vehicle& a, const Vehicle& b) {
  if (glm::distance(a.position, b.position) > 12) return false;
  const auto first = CornersOf(a);
  const auto second = CornersOf(b);
  return !Parted(first, second) && !Parted(second, first);
}

class TrafficOfSeed : public testing::TestWithParam<uint64_t> {
 protected:
  RoadNetwork network_{NetworkConfig(), GetParam()};
  Route route_ = *MakeRoute(network_, "1");
};

TEST_P(TrafficOfSeed, VehiclesNeverTouch) {
  Simulation simulation(network_, route_, {30, 20}, GetParam());
  for (int step = 0; step < 4000; ++step) {
    simulation.Step(kStep);
    const auto& vehicles = simulation.vehicles().all();
    for (size_t i = 0; i < vehicles.size(); ++i) {
      for (size_t k = i + 1; k < vehicles.size(); ++k) {
        ASSERT_FALSE(Overlap(vehicles[i], vehicles[k]))
            << i << " and " << k << " at " << simulation.seconds() << " s";
      }
    }
  }
}

TEST_P(TrafficOfSeed, EverybodyGetsOn) {
  Simulation simulation(network_, route_, {20, 10}, GetParam());
  for (int step = 0; step < 2400; ++step) simulation.Step(kStep);
  ASSERT_GE(simulation.vehicles().all().size(), 21U);
  ASSERT_EQ(simulation.pedestrians().all().size(), 10U);
  int stuck = 0;
  for (const Vehicle& vehicle : simulation.vehicles().all()) stuck += vehicle.travelled < 60 ? 1 : 0;
  EXPECT_LE(stuck, 2) << "vehicles that made less than 60 m in two minutes";
  for (const Pedestrian& person : simulation.pedestrians().all()) EXPECT_GT(person.travelled, 20);
}

TEST_P(TrafficOfSeed, EgoArrives) {
  Simulation simulation(network_, route_, {20, 10}, GetParam());
  while (simulation.seconds() < 400 && simulation.Ego().travelled < route_.path.length())
    simulation.Step(kStep);
  EXPECT_GE(simulation.Ego().travelled, route_.path.length());
}

TEST_P(TrafficOfSeed, NobodyDrivesWherePeopleCross) {
  Simulation simulation(network_, route_, {25, 60}, GetParam());
  int crossed = 0;
  for (int step = 0; step < 2400; ++step) {
    simulation.Step(kStep);
    for (const Pedestrian& person : simulation.pedestrians().all()) {
      if (person.ground > 0.01) continue;  // on the pavement
      ++crossed;
      for (const Vehicle& vehicle : simulation.vehicles().all()) {
        EXPECT_GT(glm::distance(vehicle.position, person.position), vehicle.width / 2);
      }
    }
  }
  EXPECT_GT(crossed, 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, TrafficOfSeed, testing::Values(1, 2, 3));

TEST(Traffic, StandsAtRedAndFollowsTheLights) {
  const RoadNetwork network(NetworkConfig(), 1);
  const Route route = *MakeRoute(network, "1");
  Simulation simulation(network, route, {30, 10}, 1);
  int waited = 0;
  for (int step = 0; step < 2400; ++step) {
    simulation.Step(kStep);
    for (const Vehicle& vehicle : simulation.vehicles().all()) waited += vehicle.speed < 0.05 ? 1 : 0;
  }
  EXPECT_GT(waited, 200) << "somebody has to wait now and then";
}

TEST(Traffic, EmptyStreetsNeedNoStop) {
  const RoadNetwork network(NetworkConfig(), 1);
  Simulation simulation(network, *MakeRoute(network, "2"), {0, 0}, 1);
  for (int step = 0; step < 100; ++step) simulation.Step(kStep);
  double slowest = 100;
  while (simulation.Ego().travelled < 240) {
    simulation.Step(kStep);
    slowest = std::min(slowest, simulation.Ego().speed);
    ASSERT_LT(simulation.seconds(), 120);
  }
  EXPECT_GT(slowest, 2.0);
}

TEST(Traffic, EgoMovesSmoothly) {
  const RoadNetwork network(NetworkConfig(), 1);
  Simulation simulation(network, *MakeRoute(network, "1"), {20, 10}, 1);
  EgoState last = simulation.Ego();
  for (int step = 0; step < 2000; ++step) {
    simulation.Step(kStep);
    const EgoState now = simulation.Ego();
    EXPECT_LT(std::abs(std::remainder(now.heading - last.heading, 2 * 3.141592653589793)), 0.06);
    EXPECT_LT(std::abs(now.speed - last.speed), 8.1 * kStep);
    EXPECT_LT(glm::distance(now.position, last.position), 0.6);
    last = now;
  }
}

TEST(Traffic, SameSeedSameStates) {
  const RoadNetwork network(NetworkConfig(), 1);
  const Route route = *MakeRoute(network, "3");
  Simulation a(network, route, {20, 10}, 5);
  Simulation b(network, route, {20, 10}, 5);
  Simulation other(network, route, {20, 10}, 6);
  for (int step = 0; step < 400; ++step) {
    a.Step(kStep);
    b.Step(kStep);
    other.Step(kStep);
  }
  bool differs = false;
  for (size_t i = 0; i < a.vehicles().all().size(); ++i) {
    EXPECT_EQ(a.vehicles().all()[i].position, b.vehicles().all()[i].position);
    differs |= a.vehicles().all()[i].position != other.vehicles().all()[i].position;
  }
  EXPECT_TRUE(differs);
}

TEST(Signals, GivesGreenToOneSideAtATime) {
  const RoadNetwork network(NetworkConfig(), 1);
  Signals signals(network);
  const int crossing = network.JunctionAt(1, 1);
  std::vector<JunctionDemand> demands(network.junctions().size());
  JunctionDemand& demand = demands[static_cast<size_t>(crossing)];
  demand.vehicle_near = {true, true, true, true};
  demand.pedestrian_waits = true;
  std::array<int, kSides> greens{};
  int walks = 0;
  for (int step = 0; step < 4000; ++step) {
    signals.Step(kStep, demands);
    int open = signals.PedestriansMayStart(crossing) ? 1 : 0;
    walks += open;
    for (int side = 0; side < kSides; ++side) {
      const bool green = signals.VehicleLight(crossing, side) != Light::kRed;
      open += green ? 1 : 0;
      greens[static_cast<size_t>(side)] += green ? 1 : 0;
    }
    ASSERT_LE(open, 1);
  }
  for (const int green : greens) EXPECT_GT(green, 200);
  EXPECT_GT(walks, 100);
}

TEST(Signals, WaitsUntilTheJunctionIsEmpty) {
  const RoadNetwork network(NetworkConfig(), 1);
  Signals signals(network);
  const int crossing = network.JunctionAt(1, 1);
  std::vector<JunctionDemand> demands(network.junctions().size());
  demands[static_cast<size_t>(crossing)].vehicle_near[0] = true;
  demands[static_cast<size_t>(crossing)].occupied = true;
  for (int step = 0; step < 200; ++step) signals.Step(kStep, demands);
  EXPECT_EQ(signals.VehicleLight(crossing, 0), Light::kRed);
  demands[static_cast<size_t>(crossing)].occupied = false;
  signals.Step(kStep, demands);
  EXPECT_EQ(signals.VehicleLight(crossing, 0), Light::kGreen);
}

}  // namespace
}  // namespace semmap::town
