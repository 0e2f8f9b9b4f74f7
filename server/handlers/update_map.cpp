#include <spdlog/spdlog.h>

#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "server/map_description.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

absl::StatusOr<storage::MapChanges> ReadChanges(const v1::UpdateMapRequest& request) {
  storage::MapChanges changes;
  for (const std::string& path : request.update_mask().paths()) {
    if (path == "display_name") {
      SEMMAP_RETURN_IF_ERROR(CheckDisplayName(request.map().display_name()));
      changes.display_name = request.map().display_name();
    } else if (path == "labels") {
      SEMMAP_ASSIGN_OR_RETURN(changes.labels, ReadLabels(request.map()));
    } else if (path == "anchor" && !request.map().has_anchor()) {
      changes.anchor.emplace();
    } else if (path == "anchor") {
      SEMMAP_ASSIGN_OR_RETURN(changes.anchor, ReadAnchor(request.map().anchor()));
    } else {
      return Error(v1::ERROR_REASON_FIELD_INVALID, "update_mask may name display_name, labels and anchor",
                   {{"field", "update_mask"}});
    }
  }
  if (!request.update_mask().paths().empty()) return changes;
  return FieldInvalid("update_mask", "is missing");
}

absl::Status EtagMismatch(const std::string& map_id) {
  return Error(v1::ERROR_REASON_ETAG_MISMATCH, "the map has changed", {{"map", map_id}});
}

absl::StatusOr<storage::MapInfo> Update(const ServiceContext& context, const v1::UpdateMapRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(storage::MapChanges changes, ReadChanges(request));
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "map.name", request.map().name()));
  if (!request.map().etag().empty()) {
    if (request.map().etag() != EtagOf(map)) return EtagMismatch(map.name);
    changes.expected = {map.version, map.revision};
  }
  auto updated = context.store->UpdateMap(map.id, changes);
  if (absl::IsAborted(updated.status())) return EtagMismatch(map.name);
  if (!updated.ok()) return FromStore(updated.status());
  spdlog::info("map updated map={} fields={}", map.name, request.update_mask().ShortDebugString());
  return updated;
}

}  // namespace

absl::StatusOr<v1::Map> UpdateMap(const ServiceContext& context, const v1::UpdateMapRequest& request) {
  SEMMAP_RETURN_IF_ERROR(ValidateRequestId(request.request_id()));
  v1::Map answer;
  if (const auto known = context.requests->Find("UpdateMap", request.request_id())) {
    answer.ParseFromString(*known);
    return answer;
  }
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo updated, Update(context, request));
  answer = ToProto(updated);
  context.requests->Remember("UpdateMap", request.request_id(), answer.SerializeAsString());
  return answer;
}

}  // namespace semmap::server
