#include <memory>
#include <string>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/handlers/map_rework.h"
#include "server/handlers/start_operation.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "slam/common/status_macros.h"
#include "slam/pipeline/map_pruner.h"

namespace semmap::server {
namespace {

constexpr double kPruneLoaded = 0.2;
constexpr double kPruned = 0.6;

struct PruneJob {
  storage::MapInfo map;
  PruneBudget budget;
  std::shared_ptr<SessionRegistry::MapHold> hold;  // null when it is only counted
};

OperationResult Prune(const ServiceContext& context, const PruneJob& job, OperationProgress& progress) {
  progress.Enter("loading");
  SEMMAP_ASSIGN_OR_RETURN(storage::RestoredMap loaded, LoadWholeMap(context, job.map.id));
  progress.Enter("choosing what goes");
  SEMMAP_ASSIGN_OR_RETURN(const PruneResult result,
                          PruneToBudget(job.budget, CameraOf(context, loaded.info.rig), &loaded.map,
                                        ReportPart(progress, kPruneLoaded, kPruned)));
  v1::PruneReport report;
  report.set_removed_keyframes(static_cast<int64_t>(result.removed_keyframes));
  report.set_removed_points(static_cast<int64_t>(result.removed_points));
  storage::MapInfo pruned = loaded.info;
  pruned.keyframe_count = loaded.map.keyframes().size();
  pruned.point_count = loaded.map.points().size();
  const bool changes = result.removed_keyframes + result.removed_points > 0;
  if (job.hold != nullptr && changes) {
    SEMMAP_RETURN_IF_ERROR(CheckCancelled(progress));
    progress.Enter("storing");
    storage::MapRewrite rewrite;
    rewrite.map = {loaded.info.id, loaded.info.version};
    rewrite.changes = loaded.map.TakeDelta();
    SEMMAP_ASSIGN_OR_RETURN(pruned, StoreRework(context, rewrite, ReportPart(progress, kPruned, 1)));
    spdlog::info("map pruned map={} keyframes={} removed={} points={} removed={}", pruned.name,
                 pruned.keyframe_count, result.removed_keyframes, pruned.point_count, result.removed_points);
  }
  progress.Tell(report);
  return std::make_unique<v1::Map>(ToProto(pruned));
}

absl::Status CheckNotNegative(const char* field, int64_t value) {
  return value >= 0 ? absl::OkStatus() : FieldInvalid(field, "is negative");
}

absl::StatusOr<PruneBudget> ReadBudget(const v1::PruneMapRequest& request) {
  SEMMAP_RETURN_IF_ERROR(CheckNotNegative("max_keyframes", request.max_keyframes()));
  SEMMAP_RETURN_IF_ERROR(CheckNotNegative("max_points", request.max_points()));
  if (request.max_keyframes() == 0 && request.max_points() == 0) {
    return Error(v1::ERROR_REASON_FIELD_INVALID, "max_keyframes or max_points must be given",
                 {{"field", "max_keyframes"}});
  }
  return PruneBudget{static_cast<size_t>(request.max_keyframes()), static_cast<size_t>(request.max_points())};
}

}  // namespace

absl::StatusOr<v1::Operation> PruneMap(const ServiceContext& context, const v1::PruneMapRequest& request) {
  PruneJob job;
  SEMMAP_ASSIGN_OR_RETURN(job.budget, ReadBudget(request));
  return StartOperation(context, "PruneMap", request.request_id(), [&]() -> absl::StatusOr<v1::Operation> {
    SEMMAP_ASSIGN_OR_RETURN(job.map, FindMap(context, "name", request.name()));
    SEMMAP_RETURN_IF_ERROR(RequireUnused(context, job.map.name));
    if (!request.validate_only()) {
      SEMMAP_ASSIGN_OR_RETURN(job.hold, context.sessions->Hold({job.map.name}));
    }
    const std::string name = job.map.name;
    return context.operations->Start(v1::OPERATION_KIND_PRUNE, {name},
                                     [context, job = std::move(job)](OperationProgress& progress) {
                                       return Prune(context, job, progress);
                                     });
  });
}

}  // namespace semmap::server
