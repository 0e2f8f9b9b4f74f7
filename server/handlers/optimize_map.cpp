#include <memory>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/handlers/map_rework.h"
#include "server/handlers/start_operation.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "slam/common/status_macros.h"
#include "slam/pipeline/map_optimizer.h"

namespace semmap::server {
namespace {

constexpr int kMaxIterations = 1000;
// Enough for what vehicles leave: the solver stops earlier when nothing is left to gain.
constexpr int kDefaultIterations = 40;
constexpr double kOptimizeLoaded = 0.2;
constexpr double kOptimized = 0.7;

v1::OptimizeReport ReportOf(const OptimizeResult& result) {
  v1::OptimizeReport report;
  report.set_initial_rms_px(result.initial_rms_px);
  report.set_final_rms_px(result.final_rms_px);
  report.set_iterations(result.iterations);
  report.set_removed_observations(static_cast<int64_t>(result.removed_observations));
  return report;
}

OperationResult Optimize(const ServiceContext& context, storage::MapId map, int iterations,
                         OperationProgress& progress) {
  progress.Enter("loading");
  SEMMAP_ASSIGN_OR_RETURN(storage::RestoredMap loaded, LoadWholeMap(context, map));
  progress.Report(kOptimizeLoaded);
  progress.Enter("adjusting");
  const MappingCamera camera = CameraOf(context, loaded.info.rig);
  const OptimizeResult result = OptimizeWholeMap(iterations, camera, progress.cancel_flag(), &loaded.map);
  SEMMAP_RETURN_IF_ERROR(CheckCancelled(progress));
  progress.Enter("storing");
  storage::MapRewrite rewrite;
  rewrite.map = {loaded.info.id, loaded.info.version};
  rewrite.changes = loaded.map.TakeDelta();
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo stored,
                          StoreRework(context, rewrite, ReportPart(progress, kOptimized, 1)));
  progress.Tell(ReportOf(result));
  spdlog::info("map optimized map={} iterations={} rms_px={:.3f} before={:.3f}", stored.name,
               result.iterations, result.final_rms_px, result.initial_rms_px);
  return std::make_unique<v1::Map>(ToProto(stored));
}

}  // namespace

absl::StatusOr<v1::Operation> OptimizeMap(const ServiceContext& context,
                                          const v1::OptimizeMapRequest& request) {
  if (request.max_iterations() < 0 || request.max_iterations() > kMaxIterations) {
    return FieldInvalid("max_iterations", "must be in [0, 1000]");
  }
  const int iterations = request.max_iterations() == 0 ? kDefaultIterations : request.max_iterations();
  return StartOperation(context, "OptimizeMap", request.request_id(), [&]() -> absl::StatusOr<v1::Operation> {
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "name", request.name()));
    if (map.keyframe_count == 0)
      return Error(v1::ERROR_REASON_MAP_EMPTY, "the map has no keyframes", {{"map", map.name}});
    SEMMAP_ASSIGN_OR_RETURN(auto hold, context.sessions->Hold({map.name}));
    // The work keeps the hold for as long as it lives.
    return context.operations->Start(
        v1::OPERATION_KIND_OPTIMIZE, {map.name},
        [context, id = map.id, iterations, hold = std::move(hold)](OperationProgress& progress) {
          return Optimize(context, id, iterations, progress);
        });
  });
}

}  // namespace semmap::server
