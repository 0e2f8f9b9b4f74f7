#include "server/point_filter.h"

#include <string>

#include "server/error_reasons.h"
#include "server/map_conversion.h"
#include "slam/common/status_macros.h"
#include "slam/semantics/taxonomy.h"

namespace semmap::server {
namespace {

constexpr int kMaxClasses = 256;

absl::Status ReadClasses(const v1::MapPointFilter& filter, storage::MapPointQuery* query) {
  if (filter.semantic_classes_size() > kMaxClasses)
    return FieldInvalid("filter.semantic_classes", "has too many");
  for (const uint32_t semantic_class : filter.semantic_classes()) {
    if (semantic_class > 255) return FieldInvalid("filter.semantic_classes", "must be at most 255");
    query->classes.push_back(static_cast<uint8_t>(semantic_class));
  }
  return absl::OkStatus();
}

bool IsActive(uint8_t semantic_class) {
  static const ClassSet inactive(kInactiveClasses);
  return !inactive.Contains(semantic_class);
}

}  // namespace

bool PointFilter::Contains(const MapPointRecord& point) const {
  return area.Contains(point.position_in_map, point.id.value()) &&
         (!active_only || IsActive(point.semantic_class));
}

absl::StatusOr<PointFilter> FromProto(const v1::MapPointFilter& filter) {
  PointFilter result;
  SEMMAP_RETURN_IF_ERROR(ReadClasses(filter, &result.query));
  if (!(filter.min_class_confidence() >= 0 && filter.min_class_confidence() <= 1)) {
    return FieldInvalid("filter.min_class_confidence", "must be between 0 and 1");
  }
  if (filter.min_observations() < 0) return FieldInvalid("filter.min_observations", "must not be negative");
  result.query.min_confidence = static_cast<float>(filter.min_class_confidence());
  result.query.min_observations = static_cast<uint32_t>(filter.min_observations());
  if (filter.has_seen()) {
    SEMMAP_ASSIGN_OR_RETURN(result.query.seen, FromProto(filter.seen()));
  }
  SEMMAP_ASSIGN_OR_RETURN(result.area, FromProto(filter.area()));
  result.query.box = result.area.box;
  result.active_only = filter.active_only();
  return result;
}

}  // namespace semmap::server
