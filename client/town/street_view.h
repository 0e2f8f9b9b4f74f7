#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "client/town/road_network.h"

namespace semmap::town {

// Where along an arm of a junction things lie, metres outwards from where the street begins.
inline constexpr double kCrossingFrom = 0.8;
inline constexpr double kCrossingTo = 4.0;
inline constexpr double kStopLineAt = 5.2;

// A street as seen from one of its junctions, leaving it.
struct ArmView {
  const Street* street = nullptr;
  int side = 0;
  Path path;  // outwards
};

ArmView ViewArm(const RoadNetwork& network, const Junction& junction, int side);

// Lights, stop lines and zebra crossings are where three or four streets meet.
inline bool HasCrossings(const Junction& junction) { return junction.ArmCount() >= 3; }

// The line from the left edge (looking outwards) of arm `a` to the right edge of the next arm `b`
// counter-clockwise, `extra` metres outside the kerb.
std::vector<glm::dvec2> EdgeCurve(const RoadNetwork& network, const Junction& junction, int a, int b,
                                  double extra);

// The sides of a junction's streets, counter-clockwise.
std::vector<int> ArmsOf(const Junction& junction);

inline glm::vec3 Lift(const glm::dvec2& point, double z) {
  return {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(z)};
}

// Smallest distance from a point to any street's centre line, less half of that street with its pavements.
double ClearanceFromStreets(const RoadNetwork& network, const glm::dvec2& point);

}  // namespace semmap::town
