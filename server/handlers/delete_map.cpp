#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

#include <spdlog/spdlog.h>

namespace semmap::server {
namespace {

absl::Status Delete(const ServiceContext& context, const v1::DeleteMapRequest& request) {
  const auto map = FindMap(context, "name", request.name());
  if (!map.ok()) {
    const bool missing = ReasonOf(map.status()) == v1::ERROR_REASON_MAP_NOT_FOUND;
    return missing && request.allow_missing() ? absl::OkStatus() : map.status();
  }
  if (!request.etag().empty() && request.etag() != EtagOf(*map)) {
    return Error(v1::ERROR_REASON_ETAG_MISMATCH, "the map has changed", {{"map", map->name}});
  }
  SEMMAP_RETURN_IF_ERROR(RequireUnused(context, map->name));
  SEMMAP_RETURN_IF_ERROR(FromStore(context.store->DeleteMap(map->id)));
  context.watchers->OnReset(map->id);
  spdlog::info("map deleted map={}", map->name);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<google::protobuf::Empty> DeleteMap(const ServiceContext& context,
                                                  const v1::DeleteMapRequest& request) {
  SEMMAP_RETURN_IF_ERROR(ValidateRequestId(request.request_id()));
  if (context.requests->Find("DeleteMap", request.request_id()).has_value()) return google::protobuf::Empty();
  SEMMAP_RETURN_IF_ERROR(Delete(context, request));
  context.requests->Remember("DeleteMap", request.request_id(), "");
  return google::protobuf::Empty();
}

}  // namespace semmap::server
