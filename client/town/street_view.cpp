#include "client/town/street_view.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace semmap::town {

ArmView ViewArm(const RoadNetwork& network, const Junction& junction, int side) {
  ArmView arm;
  arm.street = &network.streets()[static_cast<size_t>(junction.street[static_cast<size_t>(side)])];
  arm.side = side;
  arm.path = arm.street->from == junction.id ? arm.street->centre : arm.street->centre.Reversed();
  return arm;
}

std::vector<int> ArmsOf(const Junction& junction) {
  std::vector<int> arms;
  for (int side = 0; side < kSides; ++side) {
    if (junction.street[static_cast<size_t>(side)] >= 0) arms.push_back(side);
  }
  return arms;
}

std::vector<glm::dvec2> EdgeCurve(const RoadNetwork& network, const Junction& junction, int a, int b,
                                  double extra) {
  const auto half = [&](int side) {
    return network.streets()[static_cast<size_t>(junction.street[static_cast<size_t>(side)])].HalfRoad() +
           extra;
  };
  const auto left_of = [](const glm::dvec2& d) { return glm::dvec2(-d.y, d.x); };
  const glm::dvec2 da = DirectionOf(a);
  const glm::dvec2 db = DirectionOf(b);
  const glm::dvec2 start = junction.centre + da * junction.half_size + left_of(da) * half(a);
  const glm::dvec2 end = junction.centre + db * junction.half_size - left_of(db) * half(b);
  constexpr int kSamples = 10;
  if (b == OppositeOf(a)) return SampleQuadratic(start, (start + end) * 0.5, end, kSamples);
  const glm::dvec2 corner = junction.centre + left_of(da) * half(a) - left_of(db) * half(b);
  return SampleQuadratic(start, corner, end, kSamples);
}

double ClearanceFromStreets(const RoadNetwork& network, const glm::dvec2& point) {
  double clearance = 1e9;
  for (const Street& street : network.streets()) {
    const double distance = glm::distance(point, street.centre.PointAt(street.centre.Project(point)));
    clearance = std::min(clearance, distance - street.HalfRoad() - kSidewalkWidth);
  }
  for (const Junction& junction : network.junctions()) {
    const glm::dvec2 away = glm::abs(point - junction.centre);
    clearance = std::min(clearance, std::max(away.x, away.y) - junction.half_size);
  }
  return clearance;
}

}  // namespace semmap::town
