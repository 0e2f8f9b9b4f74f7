#include <memory>

#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/handlers/start_operation.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

absl::StatusOr<std::unique_ptr<google::protobuf::Message>> Copy(const ServiceContext& context,
                                                                storage::MapId map, const std::string& new_id,
                                                                OperationProgress& progress) {
  const auto copy = context.store->CopyMap(map, new_id, context.wall_clock(), [&](double share) {
    progress.Report(share);
    return !progress.CancelRequested();
  });
  if (absl::IsCancelled(copy.status())) return copy.status();
  if (absl::IsAlreadyExists(copy.status())) {
    return Error(v1::ERROR_REASON_MAP_EXISTS, MapName(new_id) + " exists", {{"map", new_id}});
  }
  if (absl::IsAborted(copy.status())) return WithReason(copy.status(), v1::ERROR_REASON_ETAG_MISMATCH);
  if (!copy.ok()) return FromStore(copy.status());
  return std::make_unique<v1::Map>(ToProto(*copy));
}

}  // namespace

absl::StatusOr<v1::Operation> CopyMap(const ServiceContext& context, const v1::CopyMapRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string new_id, ParseMapName("new_name", request.new_name()));
  return StartOperation(context, "CopyMap", request.request_id(), [&]() -> absl::StatusOr<v1::Operation> {
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "name", request.name()));
    SEMMAP_RETURN_IF_ERROR(RequireUnused(context, map.name));
    if (context.store->GetMap(new_id).ok()) {
      return Error(v1::ERROR_REASON_MAP_EXISTS, request.new_name() + " exists", {{"map", new_id}});
    }
    return context.operations->Start(v1::OPERATION_KIND_COPY, {map.name, new_id},
                                     [context, id = map.id, new_id](OperationProgress& progress) {
                                       return Copy(context, id, new_id, progress);
                                     });
  });
}

}  // namespace semmap::server
