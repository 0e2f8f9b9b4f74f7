#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

#include <spdlog/spdlog.h>

namespace semmap::server {
absl::StatusOr<v1::Map> RenameMap(const ServiceContext& context, const v1::RenameMapRequest& request) {
  SEMMAP_RETURN_IF_ERROR(ValidateRequestId(request.request_id()));
  SEMMAP_ASSIGN_OR_RETURN(const std::string new_id, ParseMapName("new_name", request.new_name()));
  v1::Map answer;
  if (const auto known = context.requests->Find("RenameMap", request.request_id())) {
    answer.ParseFromString(*known);
    return answer;
  }
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "name", request.name()));
  SEMMAP_RETURN_IF_ERROR(RequireUnused(context, map.name));
  SEMMAP_RETURN_IF_ERROR(RequireUnused(context, new_id));
  const auto renamed = context.store->RenameMap(map.id, new_id);
  if (absl::IsAlreadyExists(renamed.status())) {
    return Error(v1::ERROR_REASON_MAP_EXISTS, request.new_name() + " exists", {{"map", new_id}});
  }
  if (!renamed.ok()) return FromStore(renamed.status());
  spdlog::info("map renamed map={} to={}", map.name, new_id);
  answer = ToProto(*renamed);
  context.requests->Remember("RenameMap", request.request_id(), answer.SerializeAsString());
  return answer;
}

}  // namespace semmap::server
