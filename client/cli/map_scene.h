#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace semmap::client {

// What a picture of a map shows. Everything is in the map frame.
struct MapScene {
  struct Point {
    Eigen::Vector3f position;
    uint8_t semantic_class = 255;
  };
  // Where one vehicle drove, frame by frame.
  struct Path {
    std::string name;
    std::vector<Eigen::Vector3d> positions;
  };
  std::vector<Point> points;
  std::vector<Path> paths;
  // Away from the ground, unit length.
  Eigen::Vector3d up = -Eigen::Vector3d::UnitY();
};

// Points in the axes of the ground: x and y along it, z up from it. Without tilt (up = -y, as camera maps
// are) x is the map's x and y its z.
class GroundFrame {
 public:
  explicit GroundFrame(const Eigen::Vector3d& up);
  Eigen::Vector3d FromMap(const Eigen::Vector3d& point_in_map) const { return rotation_ * point_in_map; }

 private:
  Eigen::Matrix3d rotation_;  // ground_from_map
};

// The scene as it is drawn: in the ground frame, without the few points that lie so far off that all else
// would shrink to a dot.
struct GroundScene {
  using Point = MapScene::Point;
  std::vector<Point> points;
  std::vector<MapScene::Path> paths;
  Eigen::AlignedBox3d box;  // around all of it; a unit box when there is nothing
  double ground_height = 0;
  size_t left_out = 0;
};

GroundScene PutOnGround(const MapScene& scene);

// Points of each class id.
std::array<size_t, 256> CountClasses(const GroundScene& scene);

}  // namespace semmap::client
