#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/town/curve.h"

namespace semmap::town {

// Sides of a junction, counter-clockwise from east; the values are indices.
enum class Side : int { kEast = 0, kNorth = 1, kWest = 2, kSouth = 3 };
inline constexpr int kSides = 4;
glm::dvec2 DirectionOf(int side);
inline int OppositeOf(int side) { return (side + 2) % kSides; }

inline constexpr double kLaneWidth = 3.4;
inline constexpr double kParkingWidth = 2.2;
inline constexpr double kSidewalkWidth = 3.2;
inline constexpr double kKerbHeight = 0.13;

// A place where streets meet. Streets leave it exactly along the axes, `half_size` metres from the centre.
struct Junction {
  int id = 0;
  int column = 0;
  int row = 0;
  glm::dvec2 centre{0, 0};
  double half_size = 0;
  std::array<int, kSides> street{-1, -1, -1, -1};  // the street that leaves on each side; -1: none

  int ArmCount() const;
  // Two streets at a right angle: the road only bends here, without lights or crossings.
  bool IsBend() const { return ArmCount() == 2; }
};

// A street between two junctions, one lane each way. Its line runs west to east or south to north, in bends.
struct Street {
  int id = 0;
  bool horizontal = true;
  int from = 0;  // junction at the start of `centre`
  int to = 0;
  Path centre;
  double median = 0;        // width of a tram track bed in the middle, 0: none
  bool has_bridge = false;  // crosses the canal
  double bridge_from = 0;   // along `centre`
  double bridge_to = 0;

  // From the centre line to the kerb.
  double HalfRoad() const { return median / 2 + kLaneWidth + kParkingWidth; }
  double LaneOffset() const { return median / 2 + kLaneWidth / 2; }
};

// One direction of a street; the curve runs the way one drives (on the right).
struct Lane {
  int id = 0;
  int street = 0;
  bool forward = true;  // along the street's line
  int from = 0;         // junctions
  int to = 0;
  Path path;
};

// The way through a junction from the end of one lane to the start of another.
struct Turn {
  int id = 0;
  int junction = 0;
  int from_lane = 0;
  int to_lane = 0;
  int from_side = 0;  // the side of the junction that one comes from
  int to_side = 0;
  Path path;
};

struct NetworkConfig {
  int columns = 4;       // junctions, 3 to 8
  int rows = 4;          // 3 to 8
  double spacing = 108;  // metres between junctions, 90 to 200
  double jitter = 7;     // of a junction's place
  double bulge = 10;     // greatest sideways swing of a street
};

// The canal that crosses the town from west to east, below the level of the streets.
struct Canal {
  double centre_y = 0;
  double half_width = 6;
};

// The streets of one town. Immutable after its making.
class RoadNetwork {
 public:
  RoadNetwork(const NetworkConfig& config, uint64_t seed);

  const NetworkConfig& config() const { return config_; }
  const std::vector<Junction>& junctions() const { return junctions_; }
  const std::vector<Street>& streets() const { return streets_; }
  const std::vector<Lane>& lanes() const { return lanes_; }
  const std::vector<Turn>& turns() const { return turns_; }
  const Canal& canal() const { return canal_; }
  // Turns that leave `lane`, at least one.
  const std::vector<int>& TurnsFrom(int lane) const { return turns_from_[static_cast<size_t>(lane)]; }

  int JunctionAt(int column, int row) const { return row * config_.columns + column; }
  // The lane from one junction to its neighbour; -1 if there is no street.
  int LaneBetween(int from_junction, int to_junction) const;
  // The turn between two lanes; -1 if there is none.
  int TurnBetween(int from_lane, int to_lane) const;
  // Smallest box around all junctions: min x, min y, max x, max y.
  glm::dvec2 Min() const;
  glm::dvec2 Max() const;

 private:
  void PlaceJunctions(uint64_t seed);
  void ConnectStreets(uint64_t seed);
  void AddStreet(int from, int to, bool horizontal, double bulge);
  void SizeJunctions();
  void AddLanes();
  void AddTurns();

  NetworkConfig config_;
  std::vector<Junction> junctions_;
  std::vector<Street> streets_;
  std::vector<Lane> lanes_;
  std::vector<Turn> turns_;
  std::vector<std::vector<int>> turns_from_;
  Canal canal_;
};

// A drive through the network: lanes and turns alternately, and the curve that joins them.
struct Route {
  std::string name;
  std::vector<int> lanes;
  std::vector<int> turns;    // turns[i] joins lanes[i] to lanes[i + 1]
  double start_on_lane = 0;  // where on the first lane it starts, metres
  Path path;                 // exactly the driven curve
};

// The names that MakeRoute knows, in the order in which they are documented.
const std::vector<std::string>& RouteNames();

// `1` (610 m), `2` (242 m) and `3` (456 m) stand for the paper's routes; `loop` returns over its own start by
// more than 100 m; `2-back` and `opposite` drive the streets of `2` and `loop` the other way. NOT_FOUND for
// another name.
absl::StatusOr<Route> MakeRoute(const RoadNetwork& network, const std::string& name);

}  // namespace semmap::town
