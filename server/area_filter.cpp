#include "server/area_filter.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/error_reasons.h"
#include "server/map_conversion.h"
#include "server/pose_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr int kMinCorners = 3;
constexpr int kMaxCorners = 1000;
constexpr int kMaxNearest = 100'000;
// Stands for "without bound" in the store, which wants finite boxes; no map is that large.
constexpr double kUnbounded = 1e12;

absl::Status AreaInvalid(const char* what) {
  return Error(v1::ERROR_REASON_AREA_INVALID, what, {{"field", "area"}});
}

absl::StatusOr<AreaFilter> FromSphere(const v1::Sphere& sphere) {
  const Eigen::Vector3d center = FromProto(sphere.center());
  const double radius = sphere.radius_m();
  if (!center.allFinite() || !(radius > 0 && radius < kUnbounded)) {
    return AreaInvalid("the sphere has no inside or is not finite");
  }
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(radius);
  AreaFilter result;
  result.box.emplace(center - half, center + half);
  result.contains = [center, radius](const Eigen::Vector3d& point) {
    return (point - center).squaredNorm() <= radius * radius;
  };
  return result;
}

absl::StatusOr<AreaFilter> FromNearest(const v1::Nearest& nearest) {
  const Eigen::Vector3d point = FromProto(nearest.point());
  if (!point.allFinite() || nearest.count() < 1 || nearest.count() > kMaxNearest) {
    return AreaInvalid("the nearest 1 to 100000 things of a finite point can be asked for");
  }
  AreaFilter result;
  result.nearest = {point, static_cast<size_t>(nearest.count())};
  return result;
}

// Whether a ray from `point` along the first axis crosses the border an odd number of times.
bool IsInside(const std::vector<Eigen::Vector2d>& corners, const Eigen::Vector2d& point) {
  bool inside = false;
  for (size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const Eigen::Vector2d& a = corners[i];
    const Eigen::Vector2d& b = corners[j];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double crossing = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (point.x() < crossing) inside = !inside;
  }
  return inside;
}

absl::StatusOr<AreaFilter> FromPolygon(const v1::Polygon& polygon) {
  if (polygon.corners_size() < kMinCorners || polygon.corners_size() > kMaxCorners) {
    return AreaInvalid("the polygon must have 3 to 1000 corners");
  }
  const int second_axis = polygon.plane() == v1::Polygon::PLANE_XY ? 1 : 2;
  std::vector<Eigen::Vector2d> corners;
  Eigen::AlignedBox3d box;
  for (const v1::Vector3& corner : polygon.corners()) {
    Eigen::Vector3d point = FromProto(corner);
    point[3 - second_axis] = 0;
    if (!point.allFinite()) return AreaInvalid("the polygon is not finite");
    corners.emplace_back(point.x(), point[second_axis]);
    box.extend(point);
  }
  box.min()[3 - second_axis] = -kUnbounded;
  box.max()[3 - second_axis] = kUnbounded;
  AreaFilter result;
  result.box = box;
  result.contains = [corners = std::move(corners), second_axis](const Eigen::Vector3d& point) {
    return IsInside(corners, {point.x(), point[second_axis]});
  };
  return result;
}

}  // namespace

absl::StatusOr<AreaFilter> FromProto(const v1::Area& area) {
  switch (area.area_case()) {
    case v1::Area::kBox: {
      SEMMAP_ASSIGN_OR_RETURN(const Eigen::AlignedBox3d box, FromProto(area.box()));
      AreaFilter result;
      result.box = box;
      return result;
    }
    case v1::Area::kPolygon:
      return FromPolygon(area.polygon());
    case v1::Area::kSphere:
      return FromSphere(area.sphere());
    case v1::Area::kNearest:
      return FromNearest(area.nearest());
    default:
      return AreaFilter{};
  }
}

}  // namespace semmap::server
