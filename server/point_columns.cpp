#include "server/point_columns.h"

#include <string>

#include "server/error_reasons.h"

namespace semmap::server {

absl::StatusOr<PointColumns> ReadColumns(const google::protobuf::FieldMask& mask) {
  if (mask.paths().empty()) return PointColumns();
  PointColumns columns{false, false, false, false, false, false};
  for (const std::string& path : mask.paths()) {
    if (path == "semantic_classes")
      columns.classes = true;
    else if (path == "class_confidences")
      columns.confidences = true;
    else if (path == "observation_counts")
      columns.observation_counts = true;
    else if (path == "first_seen_ns")
      columns.first_seen = true;
    else if (path == "last_seen_ns")
      columns.last_seen = true;
    else if (path == "normals")
      columns.normals = true;
    else if (path != "ids" && path != "positions")
      return Error(v1::ERROR_REASON_FIELD_INVALID, "columns names no column of MapPointColumns",
                   {{"field", "columns"}});
  }
  return columns;
}

void AppendPoint(const MapPointRecord& point, const Eigen::Vector3d& position, const PointColumns& columns,
                 v1::MapPointColumns* out) {
  out->add_ids(point.id.value());
  for (const double coordinate : {position.x(), position.y(), position.z()}) out->add_positions(coordinate);
  if (columns.classes) out->add_semantic_classes(point.semantic_class);
  if (columns.confidences) out->add_class_confidences(point.class_confidence);
  if (columns.observation_counts) out->add_observation_counts(point.observation_count);
  if (columns.first_seen) out->add_first_seen_ns(point.first_seen);
  if (columns.last_seen) out->add_last_seen_ns(point.last_seen);
  if (!columns.normals) return;
  for (const float coordinate : {point.normal.x(), point.normal.y(), point.normal.z()})
    out->add_normals(coordinate);
}

}  // namespace semmap::server
