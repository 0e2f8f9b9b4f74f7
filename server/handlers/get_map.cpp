#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

absl::StatusOr<v1::Map> GetMap(const ServiceContext& context, const v1::GetMapRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "name", request.name()));
  return ToProto(map);
}

}  // namespace semmap::server
