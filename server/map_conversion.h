#pragma once

#include "semmap/v1/map.pb.h"
#include "semmap/v1/query.pb.h"
#include "storage/map_store.h"

namespace semmap::server {

v1::Map ToProto(const storage::MapInfo& map);
v1::MapSummary ToProto(const storage::MapSummary& summary);

// Changes with every change of the map.
std::string EtagOf(const storage::MapInfo& map);

// Name of a class of semantics.proto, for people.
std::string ClassName(unsigned semantic_class);

// AREA_INVALID for an inverted box or numbers that are not finite.
absl::StatusOr<Eigen::AlignedBox3d> FromProto(const v1::Box& box);

// FIELD_INVALID when it is inverted.
absl::StatusOr<storage::TimeRange> FromProto(const v1::TimeRange& range);

}  // namespace semmap::server
