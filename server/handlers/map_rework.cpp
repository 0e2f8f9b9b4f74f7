#include "server/handlers/map_rework.h"

#include "server/error_reasons.h"
#include "slam/pipeline/frame_builder.h"

namespace semmap::server {

StepVisitor ReportPart(OperationProgress& progress, double begin, double end) {
  return [&progress, begin, end](double share) {
    progress.Report(begin + (end - begin) * share);
    return !progress.CancelRequested();
  };
}

absl::Status CheckCancelled(const OperationProgress& progress) {
  return progress.CancelRequested() ? absl::CancelledError("the operation was cancelled") : absl::OkStatus();
}

size_t MemoryLimit(const ServiceContext& context) {
  return static_cast<size_t>(context.config.map_memory_mb) << 20;
}

absl::Status FromLoader(const absl::Status& status) {
  if (absl::IsResourceExhausted(status)) return WithReason(status, v1::ERROR_REASON_MAP_TOO_LARGE);
  if (absl::IsAborted(status)) return WithReason(status, v1::ERROR_REASON_ETAG_MISMATCH);
  return FromStore(status);
}

absl::StatusOr<storage::RestoredMap> LoadWholeMap(const ServiceContext& context, storage::MapId map) {
  auto restored = storage::LoadMap(*context.store, map,
                                   ScalePyramidInfo(context.slam.orb.levels, context.slam.orb.scale_factor),
                                   MemoryLimit(context), context.slam.semantics.PointPolicy());
  if (!restored.ok()) return FromLoader(restored.status());
  return restored;
}

MappingCamera CameraOf(const ServiceContext& context, const CameraRig& rig) {
  return MakeMappingCamera(context.slam, FrameBuilder(context.slam, rig, nullptr));
}

absl::StatusOr<storage::MapInfo> StoreRework(const ServiceContext& context,
                                             const storage::MapRewrite& rewrite, const StepVisitor& visit) {
  auto stored = context.store->RewriteMap(rewrite, visit);
  if (absl::IsCancelled(stored.status())) return stored.status();
  if (!stored.ok()) return FromLoader(stored.status());
  context.watchers->OnReset(rewrite.map.map);
  if (rewrite.joined && rewrite.delete_joined) context.watchers->OnReset(rewrite.joined->map);
  return stored;
}

}  // namespace semmap::server
