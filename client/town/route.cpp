#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/town/road_network.h"

namespace semmap::town {
namespace {

struct RoutePlan {
  const char* name;
  std::vector<std::array<int, 2>> junctions;  // column, row
  double start;                               // metres along the first lane
  double length;                              // 0: to the end of the last lane
};

// Junctions of the smallest town (3 x 3) only, but for route 1, which needs a fourth column or is drawn
// shorter.
const std::vector<RoutePlan>& Plans() {
  static const std::vector<RoutePlan> plans = {
      {"1", {{0, 1}, {0, 2}, {1, 2}, {2, 2}, {2, 1}, {2, 0}, {1, 0}, {0, 0}}, 8, 610.0},
      {"2", {{1, 0}, {1, 1}, {2, 1}, {2, 2}}, 6, 242.0},
      {"2-back", {{2, 2}, {2, 1}, {1, 1}, {1, 0}}, 6, 242.0},
      {"3", {{0, 2}, {1, 2}, {1, 1}, {1, 0}, {0, 0}, {0, 1}}, 10, 456.0},
      {"loop", {{0, 1}, {0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 1}, {0, 1}, {0, 0}, {1, 0}}, 12, 0},
      {"opposite", {{1, 0}, {0, 0}, {0, 1}, {1, 1}, {2, 1}, {2, 0}, {1, 0}, {0, 0}, {0, 1}}, 12, 0},
  };
  return plans;
}

// The loop routes end this far after they came back to their start.
constexpr double kOverlap = 125.0;

absl::Status FollowJunctions(const RoadNetwork& network, const RoutePlan& plan, Route* route) {
  for (size_t i = 0; i + 1 < plan.junctions.size(); ++i) {
    const int from = network.JunctionAt(plan.junctions[i][0], plan.junctions[i][1]);
    const int to = network.JunctionAt(plan.junctions[i + 1][0], plan.junctions[i + 1][1]);
    const int lane = network.LaneBetween(from, to);
    if (lane < 0) return absl::InternalError(absl::StrCat("route ", plan.name, ": no street at leg ", i));
    if (!route->lanes.empty()) {
      const int turn = network.TurnBetween(route->lanes.back(), lane);
      if (turn < 0) return absl::InternalError(absl::StrCat("route ", plan.name, ": no turn at leg ", i));
      route->turns.push_back(turn);
      route->path.Append(network.turns()[static_cast<size_t>(turn)].path);
    }
    route->lanes.push_back(lane);
    route->path.Append(network.lanes()[static_cast<size_t>(lane)].path);
  }
  return absl::OkStatus();
}

// Length of one round of a route that drives its first lane again.
double RoundLength(const RoadNetwork& network, const Route& route) {
  double length = 0;
  for (size_t i = 0; i < route.lanes.size(); ++i) {
    if (i > 0 && route.lanes[i] == route.lanes.front()) return length;
    length += network.lanes()[static_cast<size_t>(route.lanes[i])].path.length();
    if (i < route.turns.size()) length += network.turns()[static_cast<size_t>(route.turns[i])].path.length();
  }
  return length;
}

}  // namespace

const std::vector<std::string>& RouteNames() {
  static const std::vector<std::string> names = {"1", "2", "2-back", "3", "loop", "opposite"};
  return names;
}

absl::StatusOr<Route> MakeRoute(const RoadNetwork& network, const std::string& name) {
  for (const RoutePlan& plan : Plans()) {
    if (name != plan.name) continue;
    Route route;
    route.name = name;
    route.start_on_lane = plan.start;
    if (absl::Status status = FollowJunctions(network, plan, &route); !status.ok()) return status;
    const double length = plan.length > 0 ? plan.length : RoundLength(network, route) + kOverlap;
    if (plan.start + length > route.path.length()) {
      return absl::InternalError(absl::StrCat("route ", name, " is only ", route.path.length(), " m long"));
    }
    route.path = route.path.Slice(plan.start, plan.start + length);
    return route;
  }
  return absl::NotFoundError(
      absl::StrCat("no route '", name, "'; there are ", absl::StrJoin(RouteNames(), ", ")));
}

}  // namespace semmap::town
