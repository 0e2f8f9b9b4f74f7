#pragma once

#include "absl/status/statusor.h"
#include "google/protobuf/field_mask.pb.h"
#include "semmap/v1/query.pb.h"
#include "slam/map/map_delta.h"

namespace semmap::server {

// Which of the optional columns of MapPointColumns are wanted.
struct PointColumns {
  bool classes = true;
  bool confidences = true;
  bool observation_counts = true;
  bool first_seen = true;
  bool last_seen = true;
  bool normals = true;
};

// An empty mask means all. FIELD_INVALID for a name that is none.
absl::StatusOr<PointColumns> ReadColumns(const google::protobuf::FieldMask& mask);

// `position` in the coordinates that are answered.
void AppendPoint(const MapPointRecord& point, const Eigen::Vector3d& position, const PointColumns& columns,
                 v1::MapPointColumns* out);

}  // namespace semmap::server
