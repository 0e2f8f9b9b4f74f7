#include "client/cli/map_scene.h"

#include <algorithm>
#include <cmath>

#include "slam/evaluation/statistics.h"
#include "slam/semantics/taxonomy.h"

namespace semmap::client {
namespace {

// Of each coordinate, this share of the points on either side decides nothing about what is far off.
constexpr double kTail = 0.02;
// What lies beyond the rest by more than this share of its extent is left out.
constexpr double kMargin = 0.25;
constexpr size_t kFewGroundPoints = 20;

bool IsGround(uint8_t id) {
  const auto ground = {SemanticClass::kRoad, SemanticClass::kRoadLine, SemanticClass::kSideWalk,
                       SemanticClass::kGround, SemanticClass::kTerrain};
  return std::any_of(ground.begin(), ground.end(),
                     [id](SemanticClass member) { return static_cast<uint8_t>(member) == id; });
}

// Where most points and all paths are.
Eigen::AlignedBox3d MainBox(const GroundScene& scene) {
  Eigen::AlignedBox3d box;
  for (int axis = 0; axis < 3 && !scene.points.empty(); ++axis) {
    std::vector<double> values;
    values.reserve(scene.points.size());
    for (const GroundScene::Point& point : scene.points) values.push_back(point.position[axis]);
    const double low = Percentile(values, kTail);
    const double high = Percentile(values, 1 - kTail);
    box.min()[axis] = low - kMargin * (high - low);
    box.max()[axis] = high + kMargin * (high - low);
  }
  for (const MapScene::Path& path : scene.paths) {
    for (const Eigen::Vector3d& position : path.positions) box.extend(position);
  }
  return box;
}

double GroundHeight(const GroundScene& scene) {
  std::vector<double> heights;
  for (const GroundScene::Point& point : scene.points) {
    if (IsGround(point.semantic_class)) heights.push_back(point.position.z());
  }
  return heights.size() < kFewGroundPoints ? scene.box.min().z() : Percentile(heights, 0.5);
}

Eigen::AlignedBox3d BoxAround(const GroundScene& scene) {
  Eigen::AlignedBox3d box;
  for (const GroundScene::Point& point : scene.points) box.extend(point.position.cast<double>());
  for (const MapScene::Path& path : scene.paths) {
    for (const Eigen::Vector3d& position : path.positions) box.extend(position);
  }
  if (box.isEmpty()) return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()};
  // Not flat, so that it can be divided by.
  const Eigen::Vector3d thicker = (1e-6 * std::max(1.0, box.sizes().norm()) - box.sizes().array()).max(0) / 2;
  return {box.min() - thicker, box.max() + thicker};
}

}  // namespace

GroundFrame::GroundFrame(const Eigen::Vector3d& up) {
  // The map's x, or where that stands upright its z, as it lies on the ground.
  const bool x_is_upright = std::abs(up.x()) > 0.9;
  const Eigen::Vector3d along = x_is_upright ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  rotation_.row(2) = up;
  rotation_.row(0) = (along - up * up.dot(along)).normalized();
  rotation_.row(1) = rotation_.row(2).cross(rotation_.row(0));
}

GroundScene PutOnGround(const MapScene& scene) {
  const GroundFrame ground(scene.up);
  GroundScene result;
  for (const MapScene::Path& path : scene.paths) {
    result.paths.push_back({path.name, {}});
    for (const Eigen::Vector3d& position : path.positions) {
      result.paths.back().positions.push_back(ground.FromMap(position));
    }
  }
  result.points.reserve(scene.points.size());
  for (const MapScene::Point& point : scene.points) {
    result.points.push_back(
        {ground.FromMap(point.position.cast<double>()).cast<float>(), point.semantic_class});
  }
  const Eigen::AlignedBox3d main = MainBox(result);
  result.left_out = std::erase_if(result.points, [&](const GroundScene::Point& point) {
    return !main.contains(Eigen::Vector3d(point.position.cast<double>()));
  });
  result.box = BoxAround(result);
  result.ground_height = GroundHeight(result);
  return result;
}

std::array<size_t, 256> CountClasses(const GroundScene& scene) {
  std::array<size_t, 256> counts{};
  for (const GroundScene::Point& point : scene.points) ++counts[point.semantic_class];
  return counts;
}

}  // namespace semmap::client
