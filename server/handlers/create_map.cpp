#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "server/map_description.h"
#include "server/names.h"
#include "server/placeholder_rig.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

absl::StatusOr<storage::NewMap> ReadMap(const ServiceContext& context, const v1::Map& map) {
  storage::NewMap result;
  SEMMAP_ASSIGN_OR_RETURN(result.name, ParseMapName("map.name", map.name()));
  SEMMAP_RETURN_IF_ERROR(CheckDisplayName(map.display_name()));
  result.display_name = map.display_name();
  SEMMAP_ASSIGN_OR_RETURN(result.labels, ReadLabels(map));
  if (map.has_anchor()) {
    SEMMAP_ASSIGN_OR_RETURN(result.anchor, ReadAnchor(map.anchor()));
  }
  result.created_at = context.wall_clock();
  result.rig = PlaceholderRig();
  return result;
}

}  // namespace

absl::StatusOr<v1::Map> CreateMap(const ServiceContext& context, const v1::CreateMapRequest& request) {
  SEMMAP_RETURN_IF_ERROR(ValidateRequestId(request.request_id()));
  SEMMAP_ASSIGN_OR_RETURN(const storage::NewMap map, ReadMap(context, request.map()));
  v1::Map answer;
  if (const auto known = context.requests->Find("CreateMap", request.request_id())) {
    answer.ParseFromString(*known);
    return answer;
  }
  const auto created = context.store->CreateMap(map);
  if (created.status().code() == absl::StatusCode::kAlreadyExists) {
    return Error(v1::ERROR_REASON_MAP_EXISTS, request.map().name() + " exists", {{"map", map.name}});
  }
  if (!created.ok()) return FromStore(created.status());
  answer = ToProto(*created);
  context.requests->Remember("CreateMap", request.request_id(), answer.SerializeAsString());
  return answer;
}

}  // namespace semmap::server
