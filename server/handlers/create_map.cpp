#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "server/placeholder_rig.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr size_t kMaxRequestId = 63;

absl::Status CheckFields(const v1::CreateMapRequest& request) {
  SEMMAP_RETURN_IF_ERROR(ValidateText("request_id", request.request_id(), kMaxRequestId));
  if (!request.map().display_name().empty()) return NotImplemented("map.display_name");
  if (!request.map().labels().empty()) return NotImplemented("map.labels");
  return request.map().has_anchor() ? NotImplemented("map.anchor") : absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::Map> CreateMap(const ServiceContext& context, const v1::CreateMapRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseMapName("map.name", request.map().name()));
  SEMMAP_RETURN_IF_ERROR(CheckFields(request));
  v1::Map answer;
  if (const auto known = context.requests->Find("CreateMap", request.request_id())) {
    answer.ParseFromString(*known);
    return answer;
  }
  const auto created = context.store->CreateMap({id, context.wall_clock(), PlaceholderRig(), true});
  if (created.status().code() == absl::StatusCode::kAlreadyExists) {
    return Error(v1::ERROR_REASON_MAP_EXISTS, request.map().name() + " exists", {{"map", id}});
  }
  if (!created.ok()) return FromStore(created.status());
  answer = ToProto(*created);
  context.requests->Remember("CreateMap", request.request_id(), answer.SerializeAsString());
  return answer;
}

}  // namespace semmap::server
