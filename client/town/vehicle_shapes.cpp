#include "client/town/vehicle_shapes.h"

#include <array>

namespace semmap::town {
namespace {

VehicleShape Make(Texture texture, glm::dvec2 length_width, double height, double belt,
                  std::vector<glm::dvec2> outline) {
  VehicleShape shape;
  shape.texture = texture;
  shape.length = length_width.x;
  shape.width = length_width.y;
  shape.height = height;
  shape.belt = belt;
  shape.outline = std::move(outline);
  return shape;
}

std::array<VehicleShape, kVehicleShapes> MakeShapes() {
  std::array<VehicleShape, kVehicleShapes> shapes = {
      // saloon
      Make(Texture::kCar0, {4.6, 1.8}, 1.44, 0.62,
           {{-0.5, 0.16},
            {-0.5, 0.58},
            {-0.47, 0.66},
            {-0.33, 0.69},
            {-0.2, 0.96},
            {-0.1, 1.0},
            {0.06, 0.98},
            {0.2, 0.68},
            {0.44, 0.58},
            {0.49, 0.46},
            {0.5, 0.16}}),
      // hatchback
      Make(Texture::kCar1, {4.0, 1.74}, 1.5, 0.6,
           {{-0.5, 0.16},
            {-0.5, 0.5},
            {-0.47, 0.62},
            {-0.4, 0.94},
            {-0.3, 1.0},
            {0.04, 0.98},
            {0.22, 0.65},
            {0.45, 0.55},
            {0.49, 0.42},
            {0.5, 0.16}}),
      // off-roader
      Make(Texture::kCar2, {4.6, 1.9}, 1.74, 0.6,
           {{-0.5, 0.2},
            {-0.5, 0.56},
            {-0.48, 0.62},
            {-0.44, 0.95},
            {-0.38, 1.0},
            {0.06, 0.99},
            {0.19, 0.64},
            {0.46, 0.58},
            {0.49, 0.5},
            {0.5, 0.2}}),
      // estate
      Make(Texture::kCar3, {4.7, 1.82}, 1.48, 0.6,
           {{-0.5, 0.16},
            {-0.5, 0.52},
            {-0.48, 0.62},
            {-0.42, 0.93},
            {-0.36, 0.99},
            {0.04, 1.0},
            {0.2, 0.67},
            {0.45, 0.57},
            {0.49, 0.44},
            {0.5, 0.16}}),
      // small car
      Make(Texture::kCar4, {3.5, 1.65}, 1.5, 0.58,
           {{-0.5, 0.16},
            {-0.5, 0.5},
            {-0.48, 0.62},
            {-0.41, 0.95},
            {-0.3, 1.0},
            {0.1, 0.98},
            {0.29, 0.62},
            {0.46, 0.52},
            {0.49, 0.4},
            {0.5, 0.16}}),
      // van
      Make(Texture::kVan, {5.4, 2.0}, 2.4, 0.55,
           {{-0.5, 0.12},
            {-0.5, 0.95},
            {-0.47, 1.0},
            {0.22, 1.0},
            {0.28, 0.96},
            {0.38, 0.58},
            {0.48, 0.46},
            {0.5, 0.36},
            {0.5, 0.12}}),
      // bus
      Make(Texture::kBus, {9.4, 2.45}, 3.0, 0.42,
           {{-0.5, 0.1}, {-0.5, 0.96}, {-0.49, 1.0}, {0.47, 1.0}, {0.49, 0.95}, {0.5, 0.4}, {0.5, 0.1}}),
  };
  shapes[2].wheel_radius = 0.37;
  shapes[5].wheel_radius = 0.36;
  shapes[6].wheel_radius = 0.47;
  return shapes;
}

}  // namespace

const VehicleShape& ShapeOf(int kind) {
  static const std::array<VehicleShape, kVehicleShapes> shapes = MakeShapes();
  return shapes[static_cast<size_t>(kind % kVehicleShapes)];
}

}  // namespace semmap::town
