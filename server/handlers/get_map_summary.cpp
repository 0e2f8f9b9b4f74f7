#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

absl::StatusOr<v1::MapSummary> GetMapSummary(const ServiceContext& context,
                                             const v1::GetMapSummaryRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "name", request.name()));
  const auto summary = context.store->Summarize(map.id);
  if (!summary.ok()) return FromStore(summary.status());
  return ToProto(*summary);
}

}  // namespace semmap::server
