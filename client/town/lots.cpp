#include "client/town/lots.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "client/town/random.h"
#include "client/town/street_view.h"

namespace semmap::town {
namespace {

constexpr uint64_t kBlockPurpose = 51;
constexpr uint64_t kLotPurpose = 52;
constexpr double kCanalMargin = 3.0;

class LotDivider {
 public:
  LotDivider(const RoadNetwork& network, uint64_t seed)
      : network_(network), seed_(seed), random_(seed, kLotPurpose) {}

  std::vector<Lot> Divide() {
    for (const Street& street : network_.streets()) {
      for (const int side : {1, -1}) DivideSide(street, side);
    }
    for (const Junction& junction : network_.junctions()) AddJunctionLots(junction);
    return std::move(lots_);
  }

 private:
  void Add(std::vector<glm::dvec2> corners, std::vector<EdgeKind> edges, BlockKind block) {
    Lot lot;
    lot.id = static_cast<int>(lots_.size());
    lot.corners = std::move(corners);
    lot.edges = std::move(edges);
    lot.block = block;
    lots_.push_back(std::move(lot));
  }

  double LineOf(const Street& street) const { return street.HalfRoad() + kSidewalkWidth; }

  // How much of a street's side, from its start at `junction`, belongs to the corner lot. `turn` is the
  // neighbour side that the street's side looks at: +1 counter-clockwise, -1 clockwise.
  double CornerShare(const Junction& junction, int arm, int turn) const {
    const int next = junction.street[static_cast<size_t>((arm + turn + kSides) % kSides)];
    if (next < 0 || junction.IsBend()) return 0.0;
    return kLotDepth + LineOf(network_.streets()[static_cast<size_t>(next)]) - junction.half_size;
  }

  BlockKind BlockBeside(const Street& street, int side) const {
    const Junction& start = network_.junctions()[static_cast<size_t>(street.from)];
    const int column = start.column - (!street.horizontal && side > 0 ? 1 : 0);
    const int row = start.row - (street.horizontal && side < 0 ? 1 : 0);
    return BlockAt(network_, seed_, column, row);
  }

  void DivideSide(const Street& street, int side) {
    const Junction& start = network_.junctions()[static_cast<size_t>(street.from)];
    const Junction& end = network_.junctions()[static_cast<size_t>(street.to)];
    const int out = static_cast<int>(street.horizontal ? Side::kEast : Side::kNorth);
    const double from = CornerShare(start, out, side);
    const double to = street.centre.length() - CornerShare(end, OppositeOf(out), -side);
    if (!street.has_bridge) return DivideRange(street, side, from, to);
    DivideRange(street, side, from, street.bridge_from - kCanalMargin);
    DivideRange(street, side, street.bridge_to + kCanalMargin, to);
  }

  void DivideRange(const Street& street, int side, double from, double to) {
    double s = from;
    while (to - s > 5.0) {
      double width = random_.Uniform(8.5, 17.0);
      if (to - s - width < 8.0) width = to - s > 20 ? (to - s) / 2 : to - s;
      AddStreetLot(street, side, s, s + width);
      s += width;
    }
  }

  void AddStreetLot(const Street& street, int side, double from, double to) {
    const double line = side * LineOf(street);
    const double back = line + side * kLotDepth;
    // Left to right for who looks at the lot from the street.
    const double left = side > 0 ? from : to;
    const double right = side > 0 ? to : from;
    const Path& path = street.centre;
    Add({path.OffsetPoint(left, line), path.OffsetPoint(right, line), path.OffsetPoint(right, back),
         path.OffsetPoint(left, back)},
        {EdgeKind::kStreet, EdgeKind::kParty, EdgeKind::kRear, EdgeKind::kParty}, BlockBeside(street, side));
  }

  void AddJunctionLots(const Junction& junction) {
    if (junction.IsBend()) return;
    const std::vector<int> arms = ArmsOf(junction);
    for (size_t i = 0; i < arms.size(); ++i) {
      const int a = arms[i];
      const int b = arms[(i + 1) % arms.size()];
      if (b == OppositeOf(a)) {
        AddFacingLots(junction, a);
      } else {
        AddCornerLot(junction, a, b);
      }
    }
  }

  // The straight side of a junction of three streets.
  void AddFacingLots(const Junction& junction, int a) {
    const glm::dvec2 right = DirectionOf(a);
    const glm::dvec2 away(-right.y, right.x);
    const double line = LineOf(*ViewArm(network_, junction, a).street);
    const auto at = [&](double x, double y) { return junction.centre + right * x + away * y; };
    const double h = junction.half_size;
    for (const double x : {-h, 0.0}) {
      Add({at(x, line), at(x + h, line), at(x + h, line + kLotDepth), at(x, line + kLotDepth)},
          {EdgeKind::kStreet, EdgeKind::kParty, EdgeKind::kRear, EdgeKind::kParty}, BlockKind::kBuilt);
    }
  }

  void AddCornerLot(const Junction& junction, int a, int b) {
    const ArmView arm_a = ViewArm(network_, junction, a);
    const ArmView arm_b = ViewArm(network_, junction, b);
    const double line_a = LineOf(*arm_a.street);
    const double line_b = LineOf(*arm_b.street);
    const double share_a = kLotDepth + line_b - junction.half_size;
    const double share_b = kLotDepth + line_a - junction.half_size;
    Add({arm_a.path.OffsetPoint(0, line_a), arm_a.path.OffsetPoint(share_a, line_a),
         arm_a.path.OffsetPoint(share_a, line_a + kLotDepth), arm_b.path.OffsetPoint(share_b, -line_b),
         arm_b.path.OffsetPoint(0, -line_b)},
        {EdgeKind::kStreet, EdgeKind::kParty, EdgeKind::kParty, EdgeKind::kStreet, EdgeKind::kCorner},
        CornerBlock(junction, a));
  }

  // The block between arm `a` and the next one counter-clockwise.
  BlockKind CornerBlock(const Junction& junction, int a) const {
    const bool west = a == static_cast<int>(Side::kNorth) || a == static_cast<int>(Side::kWest);
    const bool south = a == static_cast<int>(Side::kWest) || a == static_cast<int>(Side::kSouth);
    return BlockAt(network_, seed_, junction.column - (west ? 1 : 0), junction.row - (south ? 1 : 0));
  }

  const RoadNetwork& network_;
  uint64_t seed_;
  Random random_;
  std::vector<Lot> lots_;
};

}  // namespace

BlockKind BlockAt(const RoadNetwork& network, uint64_t seed, int column, int row) {
  Random random(seed, kBlockPurpose);
  const int park_column = random.Below(2);
  const int plaza_column = random.Below(network.config().columns - 1);
  const int plaza_row = network.config().rows - 2;
  if (row == 0 && column == park_column) return BlockKind::kPark;
  if (row == plaza_row && column == plaza_column && plaza_row > 1) return BlockKind::kPlaza;
  return BlockKind::kBuilt;
}

std::vector<Lot> DivideLots(const RoadNetwork& network, uint64_t seed) {
  return LotDivider(network, seed).Divide();
}

}  // namespace semmap::town
