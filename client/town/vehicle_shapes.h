#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "client/town/materials.h"

namespace semmap::town {

// A kind of vehicle: its size and the outline of its side, shared by the mesh and by the painter of its
// texture.
struct VehicleShape {
  Texture texture = Texture::kCar0;
  double length = 4.4;  // metres
  double width = 1.8;
  double height = 1.45;
  double wheel_radius = 0.32;
  double front_axle = 0.31;  // share of the length ahead of the middle
  double rear_axle = -0.29;
  // Side outline, from the rear bumper over the roof to the front bumper: x in [-0.5, 0.5] of the length, y
  // in [0, 1] of the height.
  std::vector<glm::dvec2> outline;
  double belt = 0.58;  // height of the lower edge of the windows, share
};

inline constexpr int kVehicleShapes = 7;
const VehicleShape& ShapeOf(int kind);  // [0, kVehicleShapes)

}  // namespace semmap::town
