#include "client/town/road_network.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "client/town/random.h"

namespace semmap::town {
namespace {

constexpr uint64_t kJunctionPurpose = 11;
constexpr uint64_t kStreetPurpose = 12;
constexpr double kSampleStep = 0.5;
constexpr double kBendHalfSize = 22.0;
constexpr double kKerbRadius = 6.0;
constexpr double kTramMedian = 6.4;
// The bridge's deck reaches this far beyond the canal's walls.
constexpr double kBridgeOverhang = 1.0;

// A curve from a to b that leaves and arrives along `axis` and swings `bulge` metres to the left half way.
Path BulgedCurve(glm::dvec2 a, glm::dvec2 b, glm::dvec2 axis, double bulge) {
  const glm::dvec2 chord = b - a;
  const glm::dvec2 along = glm::normalize(chord);
  const glm::dvec2 middle = (a + b) * 0.5 + glm::dvec2(-along.y, along.x) * bulge;
  const double handle = glm::length(chord) * 0.2;
  Path path(SampleCubic(a, a + axis * handle, middle - along * handle, middle, kSampleStep));
  path.Append(Path(SampleCubic(middle, middle + along * handle, b - axis * handle, b, kSampleStep)));
  return path;
}

}  // namespace

glm::dvec2 DirectionOf(int side) {
  static constexpr std::array<std::array<double, 2>, kSides> kDirections = {
      {{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const auto& direction = kDirections[static_cast<size_t>(side)];
  return {direction[0], direction[1]};
}

int Junction::ArmCount() const {
  return static_cast<int>(std::count_if(street.begin(), street.end(), [](int arm) { return arm >= 0; }));
}

RoadNetwork::RoadNetwork(const NetworkConfig& config, uint64_t seed) : config_(config) {
  PlaceJunctions(seed);
  ConnectStreets(seed);
  AddLanes();
  AddTurns();
}

void RoadNetwork::PlaceJunctions(uint64_t seed) {
  Random random(seed, kJunctionPurpose);
  for (int row = 0; row < config_.rows; ++row) {
    for (int column = 0; column < config_.columns; ++column) {
      Junction junction;
      junction.id = JunctionAt(column, row);
      junction.column = column;
      junction.row = row;
      junction.centre = {column * config_.spacing + random.Uniform(-1, 1) * config_.jitter,
                         row * config_.spacing + random.Uniform(-1, 1) * config_.jitter};
      junctions_.push_back(junction);
    }
  }
  canal_.centre_y = 1.5 * config_.spacing;
}

void RoadNetwork::SizeJunctions() {
  const double plain_half_road = kLaneWidth + kParkingWidth;
  const int tram_row = config_.rows / 2;
  for (Junction& junction : junctions_) {
    const bool corner = (junction.column == 0 || junction.column == config_.columns - 1) &&
                        (junction.row == 0 || junction.row == config_.rows - 1);
    const double widest = plain_half_road + (junction.row == tram_row ? kTramMedian / 2 : 0.0);
    junction.half_size = corner ? kBendHalfSize : widest + kKerbRadius;
  }
}

void RoadNetwork::ConnectStreets(uint64_t seed) {
  SizeJunctions();
  Random random(seed, kStreetPurpose);
  for (int row = 0; row < config_.rows; ++row) {
    for (int column = 0; column < config_.columns; ++column) {
      const int here = JunctionAt(column, row);
      // Every second street swings; the canal is crossed at a right angle, on a straight bridge.
      const double sign = random.Chance(0.5) ? 1.0 : -1.0;
      const double swing = sign * config_.bulge * random.Uniform(0.5, 1.0);
      if (column + 1 < config_.columns) {
        AddStreet(here, JunctionAt(column + 1, row), true, (row + column) % 2 == 0 ? swing : 0.0);
      }
      if (row + 1 < config_.rows) {
        AddStreet(here, JunctionAt(column, row + 1), false,
                  row != 1 && (row + column) % 2 == 1 ? swing : 0.0);
      }
    }
  }
}

void RoadNetwork::AddStreet(int from, int to, bool horizontal, double bulge) {
  Street street;
  street.id = static_cast<int>(streets_.size());
  street.horizontal = horizontal;
  street.from = from;
  street.to = to;
  Junction& start = junctions_[static_cast<size_t>(from)];
  Junction& end = junctions_[static_cast<size_t>(to)];
  const int side = static_cast<int>(horizontal ? Side::kEast : Side::kNorth);
  const glm::dvec2 axis = DirectionOf(side);
  street.centre =
      BulgedCurve(start.centre + axis * start.half_size, end.centre - axis * end.half_size, axis, bulge);
  if (horizontal && start.row == config_.rows / 2) street.median = kTramMedian;
  if (!horizontal && start.row == 1) {
    const double half = canal_.half_width + kBridgeOverhang;
    const double x = street.centre.PointAt(street.centre.length() / 2).x;
    street.has_bridge = true;
    street.bridge_from = street.centre.Project({x, canal_.centre_y - half});
    street.bridge_to = street.centre.Project({x, canal_.centre_y + half});
  }
  start.street[static_cast<size_t>(side)] = street.id;
  end.street[static_cast<size_t>(OppositeOf(side))] = street.id;
  streets_.push_back(std::move(street));
}

void RoadNetwork::AddLanes() {
  for (const Street& street : streets_) {
    const Path right = street.centre.Offset(-street.LaneOffset());
    const Path left = street.centre.Offset(street.LaneOffset()).Reversed();
    const int id = static_cast<int>(lanes_.size());
    lanes_.push_back({id, street.id, true, street.from, street.to, right});
    lanes_.push_back({id + 1, street.id, false, street.to, street.from, left});
  }
}

void RoadNetwork::AddTurns() {
  turns_from_.resize(lanes_.size());
  const auto side_of = [this](int junction, int street) {
    const auto& arms = junctions_[static_cast<size_t>(junction)].street;
    return static_cast<int>(std::distance(arms.begin(), std::find(arms.begin(), arms.end(), street)));
  };
  for (const Lane& in : lanes_) {
    for (const Lane& out : lanes_) {
      if (in.to != out.from || in.street == out.street) continue;
      const glm::dvec2 start = in.path.points().back();
      const glm::dvec2 end = out.path.points().front();
      const double handle = glm::distance(start, end) * 0.39;  // nearly a circle for a right angle
      Turn turn{static_cast<int>(turns_.size()),
                in.to,
                in.id,
                out.id,
                side_of(in.to, in.street),
                side_of(in.to, out.street),
                Path(SampleCubic(start, start + in.path.TangentAt(in.path.length()) * handle,
                                 end - out.path.TangentAt(0) * handle, end, kSampleStep))};
      turns_from_[static_cast<size_t>(in.id)].push_back(turn.id);
      turns_.push_back(std::move(turn));
    }
  }
}

int RoadNetwork::LaneBetween(int from_junction, int to_junction) const {
  for (const Lane& lane : lanes_) {
    if (lane.from == from_junction && lane.to == to_junction) return lane.id;
  }
  return -1;
}

int RoadNetwork::TurnBetween(int from_lane, int to_lane) const {
  for (const int id : turns_from_[static_cast<size_t>(from_lane)]) {
    if (turns_[static_cast<size_t>(id)].to_lane == to_lane) return id;
  }
  return -1;
}

glm::dvec2 RoadNetwork::Min() const {
  glm::dvec2 low(1e9);
  for (const Junction& junction : junctions_) low = glm::min(low, junction.centre);
  return low;
}

glm::dvec2 RoadNetwork::Max() const {
  glm::dvec2 high(-1e9);
  for (const Junction& junction : junctions_) high = glm::max(high, junction.centre);
  return high;
}

}  // namespace semmap::town
