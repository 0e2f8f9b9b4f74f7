#pragma once

#include "absl/status/statusor.h"
#include "semmap/v1/query.pb.h"
#include "server/area_filter.h"
#include "slam/map/map_delta.h"
#include "storage/map_store.h"

namespace semmap::server {

// Which points are meant: what the store looks for, and which of these it is then.
struct PointFilter {
  storage::MapPointQuery query;
  AreaFilter area;
  bool active_only = false;

  bool Contains(const MapPointRecord& point) const;
};

// FIELD_INVALID, AREA_INVALID.
absl::StatusOr<PointFilter> FromProto(const v1::MapPointFilter& filter);

}  // namespace semmap::server
