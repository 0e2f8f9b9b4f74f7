#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_set>

#include <Eigen/Geometry>

#include "absl/status/statusor.h"
#include "semmap/v1/query.pb.h"

namespace semmap::server {

// An area as the store can search it: a box around it, and what of the box is inside.
struct AreaFilter {
  // The things nearest to a point: they are found out by ResolveNearest.
  struct Nearest {
    Eigen::Vector3d point;
    size_t count = 0;
  };

  std::optional<Eigen::AlignedBox3d> box;
  std::function<bool(const Eigen::Vector3d&)> contains;  // empty: all of the box
  std::optional<Nearest> nearest;
  std::optional<std::unordered_set<uint64_t>> ids;  // no others; absent: any

  bool Contains(const Eigen::Vector3d& position, uint64_t id) const {
    return (!ids.has_value() || ids->contains(id)) && (!contains || contains(position));
  }
};

// An absent area holds everything. AREA_INVALID.
absl::StatusOr<AreaFilter> FromProto(const v1::Area& area);

}  // namespace semmap::server
