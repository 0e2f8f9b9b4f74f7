#include "client/cli/map_projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace semmap::client {
namespace {

constexpr double kFill = 0.96;  // of the area
constexpr double kElevation = 35 * std::numbers::pi / 180;
// Distance of the eye from the middle of the box, in diagonals of it.
constexpr double kDistance = 1.1;

std::array<Eigen::Vector3d, 8> CornersOf(const Eigen::AlignedBox3d& box) {
  std::array<Eigen::Vector3d, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners[i] = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
  }
  return corners;
}

// Axes of an eye at `eye` that looks at `target`, with the ground's z upwards on the picture.
Eigen::Isometry3d LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d away = (target - eye).normalized();
  const Eigen::Vector3d right = away.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), away.cross(right).transpose(), away.transpose();
  Eigen::Isometry3d view = Eigen::Isometry3d::Identity();
  view.linear() = rotation;
  view.translation() = -rotation * eye;
  return view;
}

}  // namespace

MapProjection MapProjection::Top(const Eigen::AlignedBox3d& box, const cv::Rect& area) {
  MapProjection result;
  Eigen::Matrix3d rotation;
  rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  result.view_from_ground_.linear() = rotation;
  result.view_from_ground_.translation() = -rotation * box.center();
  result.focal_ = kFill * std::min(area.width / box.sizes().x(), area.height / box.sizes().y());
  result.centre_ = {area.x + 0.5 * area.width, area.y + 0.5 * area.height};
  return result;
}

MapProjection MapProjection::Perspective(const Eigen::AlignedBox3d& box, const cv::Rect& area) {
  MapProjection result;
  result.perspective_ = true;
  const double distance = kDistance * box.sizes().norm();
  const bool wide = box.sizes().x() >= box.sizes().y();
  const Eigen::Vector3d side = wide ? Eigen::Vector3d(0, -1, 0) : Eigen::Vector3d(1, 0, 0);
  const Eigen::Vector3d to_eye =
      std::cos(kElevation) * side + std::sin(kElevation) * Eigen::Vector3d::UnitZ();
  result.view_from_ground_ = LookAt(box.center() + distance * to_eye, box.center());
  Eigen::AlignedBox2d extent;
  for (const Eigen::Vector3d& corner : CornersOf(box)) {
    const Eigen::Vector3d seen = result.view_from_ground_ * corner;
    extent.extend(Eigen::Vector2d(seen.head<2>() / seen.z()));
  }
  result.focal_ = kFill * std::min(area.width / extent.sizes().x(), area.height / extent.sizes().y());
  result.centre_ = {area.x + 0.5 * area.width - result.focal_ * extent.center().x(),
                    area.y + 0.5 * area.height - result.focal_ * extent.center().y()};
  return result;
}

std::optional<MapProjection::Pixel> MapProjection::Project(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d seen = view_from_ground_ * point;
  if (perspective_ && seen.z() <= 0) return std::nullopt;
  const double scale = perspective_ ? focal_ / seen.z() : focal_;
  return Pixel{{centre_.x + scale * seen.x(), centre_.y + scale * seen.y()}, scale, -seen.z()};
}

}  // namespace semmap::client
