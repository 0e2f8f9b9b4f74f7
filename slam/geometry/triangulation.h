#pragma once

#include <optional>

#include "slam/geometry/se3.h"

namespace semmap {

// The point seen along ray_first (from the first camera) and ray_second (from the second), both with z = 1,
// by the linear method (homogeneous least squares, Hartley and Zisserman 12.2). In the map frame; nullopt for
// rays that are parallel to working precision or a point at infinity. Does not check that it lies in front.
std::optional<Eigen::Vector3d> TriangulateLinear(const SE3& first_from_map, const SE3& second_from_map,
                                                 const Eigen::Vector3d& ray_first,
                                                 const Eigen::Vector3d& ray_second);

}  // namespace semmap
