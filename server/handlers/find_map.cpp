#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

absl::StatusOr<storage::MapInfo> FindMap(const ServiceContext& context, const char* field,
                                         const std::string& name) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseMapName(field, name));
  auto map = context.store->GetMap(id);
  if (map.ok()) return map;
  if (map.status().code() != absl::StatusCode::kNotFound) return FromStore(map.status());
  return Error(v1::ERROR_REASON_MAP_NOT_FOUND, "there is no " + name, {{"map", id}});
}

absl::StatusOr<GeoFrame> GeoFrameOf(const storage::MapInfo& map) {
  if (map.anchor.has_value()) return GeoFrame(*map.anchor);
  return Error(v1::ERROR_REASON_MAP_NOT_ANCHORED, "the map has no anchor", {{"map", map.name}});
}

absl::Status RequireUnused(const ServiceContext& context, const std::string& map_id) {
  if (!context.sessions->IsMapInUse(map_id)) return absl::OkStatus();
  return Error(v1::ERROR_REASON_MAP_IN_USE, "a session runs on the map", {{"map", map_id}});
}

}  // namespace semmap::server
