#include "tests/bench/experiment/truth_label.h"

#include <cmath>

#include "slam/geometry/camera.h"

namespace semmap::bench {
namespace {

// Mirrors and bumpers stick out of the outline.
constexpr double kOutlineMargin = 0.3;
constexpr double kStandingSpeed = 0.1;  // m/s
// Pedestrians are told apart by the nearest one; none stands further from its pixels than its arms reach.
constexpr double kArmsReach = 1.0;

constexpr auto kVehicles = static_cast<uint8_t>(SemanticClass::kVehicles);
constexpr auto kPedestrian = static_cast<uint8_t>(SemanticClass::kPedestrian);

bool IsWithin(const town::Vehicle& vehicle, const Eigen::Vector3d& point) {
  const double dx = point.x() - vehicle.position.x;
  const double dy = point.y() - vehicle.position.y;
  const double along = dx * std::cos(vehicle.heading) + dy * std::sin(vehicle.heading);
  const double across = dy * std::cos(vehicle.heading) - dx * std::sin(vehicle.heading);
  return std::abs(along) < 0.5 * vehicle.length + kOutlineMargin &&
         std::abs(across) < 0.5 * vehicle.width + kOutlineMargin;
}

TruthLabel LabelVehicle(const town::Simulation& simulation, const Eigen::Vector3d& point) {
  const auto& vehicles = simulation.vehicles().all();
  // The first one is the camera's own.
  for (size_t i = 1; i < vehicles.size(); ++i) {
    if (IsWithin(vehicles[i], point)) return {kVehicles, true, vehicles[i].speed > kStandingSpeed};
  }
  return {kVehicles, false, false};
}

TruthLabel LabelPedestrian(const town::Simulation& simulation, const Eigen::Vector3d& point) {
  for (const town::Pedestrian& person : simulation.pedestrians().all()) {
    if (std::hypot(point.x() - person.position.x, point.y() - person.position.y) < kArmsReach)
      return {kPedestrian, true, person.speed > kStandingSpeed};
  }
  return {kPedestrian, true, false};
}

}  // namespace

cv::Mat LabelTruth(const town::TownDrive& drive, const town::DriveFrame& frame) {
  const CameraIntrinsics camera = drive.config().rig.Intrinsics();
  cv::Mat labels = frame.left.mask.clone();
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      uint8_t& label = labels.at<uint8_t>(y, x);
      if (label != kVehicles && label != kPedestrian) continue;
      const double depth = frame.left.depth.at<float>(y, x);
      const Eigen::Vector3d point =
          frame.town_from_camera * (depth * RayOfPixel(camera, Eigen::Vector2d(x, y)));
      label = Encode(label == kVehicles ? LabelVehicle(drive.simulation(), point)
                                        : LabelPedestrian(drive.simulation(), point));
    }
  }
  return labels;
}

}  // namespace semmap::bench
