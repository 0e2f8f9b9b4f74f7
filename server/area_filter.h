#pragma once

#include <functional>
#include <optional>

#include <Eigen/Geometry>

#include "absl/status/statusor.h"
#include "semmap/v1/query.pb.h"

namespace semmap::server {

// An area as the store can search it: a box around it, and what of the box is inside.
struct AreaFilter {
  std::optional<Eigen::AlignedBox3d> box;
  std::function<bool(const Eigen::Vector3d&)> contains;  // empty: all of the box

  bool Contains(const Eigen::Vector3d& point) const { return !contains || contains(point); }
};

// An absent area holds everything. AREA_INVALID; NOT_IMPLEMENTED for `nearest`.
absl::StatusOr<AreaFilter> FromProto(const v1::Area& area);

}  // namespace semmap::server
