#include "client/town/road_network.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "client/town/lots.h"
#include "client/town/spawn_points.h"
#include "client/town/street_view.h"

namespace semmap::town {
namespace {

class NetworkOfSeed : public testing::TestWithParam<uint64_t> {
 protected:
  RoadNetwork network_{NetworkConfig(), GetParam()};
};

TEST_P(NetworkOfSeed, TurnsJoinLanesWithoutAKink) {
  for (const Turn& turn : network_.turns()) {
    const Path& in = network_.lanes()[static_cast<size_t>(turn.from_lane)].path;
    const Path& out = network_.lanes()[static_cast<size_t>(turn.to_lane)].path;
    EXPECT_LT(glm::distance(in.points().back(), turn.path.points().front()), 1e-6);
    EXPECT_LT(glm::distance(out.points().front(), turn.path.points().back()), 1e-6);
    EXPECT_GT(glm::dot(in.TangentAt(in.length()), turn.path.TangentAt(0)), 0.999);
    EXPECT_GT(glm::dot(out.TangentAt(0), turn.path.TangentAt(turn.path.length())), 0.999);
  }
}

TEST_P(NetworkOfSeed, EveryLaneLeadsOn) {
  for (const Lane& lane : network_.lanes()) EXPECT_FALSE(network_.TurnsFrom(lane.id).empty());
}

TEST_P(NetworkOfSeed, RoutesHaveTheLengthsOfThePaper) {
  EXPECT_NEAR(MakeRoute(network_, "1")->path.length(), 610, 0.1);
  EXPECT_NEAR(MakeRoute(network_, "2")->path.length(), 242, 0.1);
  EXPECT_NEAR(MakeRoute(network_, "3")->path.length(), 456, 0.1);
}

TEST_P(NetworkOfSeed, LoopReturnsOverItsStartByMoreThanAHundredMetres) {
  for (const char* name : {"loop", "opposite"}) {
    const auto route = MakeRoute(network_, name);
    ASSERT_TRUE(route.ok()) << route.status();
    ASSERT_GT(route->path.length(), 700);
    const double round = route->path.length() - 125;
    EXPECT_GT(round, 600) << "one long loop";
    for (double s = 0; s < 120; s += 5) {
      EXPECT_LT(glm::distance(route->path.PointAt(s), route->path.PointAt(round + s)), 0.05)
          << name << " at " << s;
    }
  }
}

TEST_P(NetworkOfSeed, OppositeRoutesDriveTheSameStreetsTheOtherWay) {
  for (const auto& [there, back] : {std::pair("loop", "opposite"), std::pair("2", "2-back")}) {
    const auto route = MakeRoute(network_, there);
    const auto opposite = MakeRoute(network_, back);
    ASSERT_TRUE(route.ok() && opposite.ok());
    for (const int lane : opposite->lanes) {
      const int other_direction = lane ^ 1;
      EXPECT_NE(std::find(route->lanes.begin(), route->lanes.end(), other_direction), route->lanes.end());
    }
  }
}

TEST_P(NetworkOfSeed, LotsKeepOffTheStreets) {
  for (const Lot& lot : DivideLots(network_, GetParam())) {
    glm::dvec2 middle(0, 0);
    for (const glm::dvec2& corner : lot.corners) middle += corner / static_cast<double>(lot.corners.size());
    for (const Street& street : network_.streets()) {
      const double distance = glm::distance(middle, street.centre.PointAt(street.centre.Project(middle)));
      EXPECT_GT(distance, street.HalfRoad() + kSidewalkWidth + 3)
          << "lot " << lot.id << ", street " << street.id;
    }
    EXPECT_GT(std::abs(middle.y - network_.canal().centre_y), network_.canal().half_width)
        << "lot " << lot.id;
  }
}

TEST_P(NetworkOfSeed, SpawnPointsAreOnTheirLanes) {
  const auto points = SpawnPoints(network_, 154);
  ASSERT_EQ(points.size(), 154U);
  for (const SpawnPoint& point : points) {
    const Path& lane = network_.lanes()[static_cast<size_t>(point.lane)].path;
    EXPECT_LT(glm::distance(lane.PointAt(lane.Project(point.position)), point.position), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, NetworkOfSeed, testing::Range<uint64_t>(1, 9));

TEST(RoadNetwork, SeedsDiffer) {
  const RoadNetwork a(NetworkConfig(), 1);
  const RoadNetwork b(NetworkConfig(), 2);
  EXPECT_NE(a.junctions()[5].centre, b.junctions()[5].centre);
}

TEST(RoadNetwork, UnknownRouteIsNotFound) {
  const RoadNetwork network(NetworkConfig(), 1);
  EXPECT_EQ(MakeRoute(network, "4").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace semmap::town
