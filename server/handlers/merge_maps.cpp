#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "absl/strings/str_cat.h"
#include "server/camera_comparison.h"
#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/handlers/map_rework.h"
#include "server/handlers/start_operation.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "server/pose_conversion.h"
#include "slam/common/status_macros.h"
#include "slam/pipeline/map_joiner.h"
#include "slam/pipeline/place_memory.h"
#include "storage/joined_map_loader.h"

namespace semmap::server {
namespace {

// Where the parts of the work end, as shares of it.
constexpr double kMergeLoaded = 0.1;
constexpr double kFound = 0.5;
constexpr double kFused = 0.6;
constexpr double kAdjusted = 0.8;

struct MergeJob {
  storage::MapInfo target;
  storage::MapInfo source;
  bool delete_source = false;
  bool validate_only = false;
  std::shared_ptr<SessionRegistry::MapHold> hold;  // null for validate_only, which changes nothing
};

bool HasDepth(const CameraRig& rig) { return rig.sensor != SensorType::kMono; }

// Depth of one of them alone says nothing of the other's unit: then both are looked at with one eye.
bool IsMixed(const MergeJob& job) { return HasDepth(job.target.rig) != HasDepth(job.source.rig); }

absl::Status CheckCameras(const storage::MapInfo& target, const storage::MapInfo& source) {
  const bool both_deep = HasDepth(target.rig) && HasDepth(source.rig);
  if (both_deep ? SameCameras(target.rig, source.rig) : SameIntrinsics(target.rig, source.rig))
    return absl::OkStatus();
  return Error(v1::ERROR_REASON_MAPS_DIFFER_IN_CAMERAS,
               "maps can be joined that were made with cameras of the same size and calibration");
}

absl::Status CheckNotEmpty(const storage::MapInfo& map) {
  if (map.keyframe_count > 0) return absl::OkStatus();
  return Error(v1::ERROR_REASON_MAP_EMPTY, MapName(map.name) + " has no keyframes", {{"map", map.name}});
}

absl::Status DoNotOverlap(const MapOverlap& overlap) {
  const std::string message = absl::StrCat(
      "of the ", overlap.keyframes, " keyframes of the map to be joined ", overlap.found,
      " were found in the other one, and of these ", overlap.links.size(),
      " agree about how the maps lie to each other",
      overlap.rivals > 0 ? absl::StrCat(", but ", overlap.rivals, " agree about something else") : "");
  return Error(v1::ERROR_REASON_MAPS_DO_NOT_OVERLAP, message,
               {{"keyframes", absl::StrCat(overlap.keyframes)},
                {"found", absl::StrCat(overlap.found)},
                {"agreeing", absl::StrCat(overlap.links.size())},
                {"rivals", absl::StrCat(overlap.rivals)}});
}

PlaceMemory RememberPlaces(const ServiceContext& context, const Map& map) {
  PlaceMemory places(context.vocabulary, context.slam.place.query, context.slam.semantics.InactiveClasses());
  std::vector<KeyFrameId> ids;
  for (const auto& [id, keyframe] : map.keyframes()) ids.push_back(id);
  // In one order always: equal scores are told apart by it.
  std::sort(ids.begin(), ids.end());
  for (const KeyFrameId id : ids) places.Add(*map.FindKeyFrame(id));
  return places;
}

absl::StatusOr<storage::JoinedMaps> Load(const ServiceContext& context, const MergeJob& job) {
  auto maps =
      storage::LoadJoinedMaps(*context.store, job.target.id, job.source.id,
                              ScalePyramidInfo(context.slam.orb.levels, context.slam.orb.scale_factor),
                              MemoryLimit(context), context.slam.semantics.PointPolicy(), IsMixed(job));
  if (!maps.ok()) return FromLoader(maps.status());
  return maps;
}

MappingCamera CameraFor(const ServiceContext& context, const MergeJob& job) {
  CameraRig rig = job.target.rig;
  if (IsMixed(job)) rig.sensor = SensorType::kMono;
  return CameraOf(context, rig);
}

// For a target without one; kept only if it has none by then.
std::optional<storage::GeoAnchor> AnchorOfSource(const MergeJob& job, const Sim3& target_from_source) {
  if (!job.source.anchor) return std::nullopt;
  storage::GeoAnchor anchor = *job.source.anchor;
  anchor.enu_from_map = anchor.enu_from_map * target_from_source.Inverse();
  return anchor;
}

void Describe(const MapOverlap& overlap, int fused, const MapJoiner& joiner,
              v1::MergeMapsResponse* response) {
  *response->mutable_target_from_source() = ToProto(overlap.target_from_source);
  response->set_overlapping_keyframes(static_cast<int64_t>(overlap.links.size()));
  response->set_fused_points(fused);
  response->set_reprojection_rms_px(joiner.MeasureSeam().rms_px);
}

absl::StatusOr<storage::MapInfo> Store(const ServiceContext& context, const MergeJob& job,
                                       const Sim3& target_from_source, storage::JoinedMaps* maps,
                                       OperationProgress& progress) {
  storage::MapRewrite rewrite;
  rewrite.map = {maps->target.id, maps->target.version};
  rewrite.joined = storage::MapRewrite::Basis{maps->source.id, maps->source.version};
  rewrite.delete_joined = job.delete_source;
  rewrite.changes = maps->map.TakeDelta();
  rewrite.anchor = AnchorOfSource(job, target_from_source);
  progress.Enter("storing");
  return StoreRework(context, rewrite, ReportPart(progress, kAdjusted, 1));
}

OperationResult Merge(const ServiceContext& context, const MergeJob& job, OperationProgress& progress) {
  progress.Enter("loading");
  SEMMAP_ASSIGN_OR_RETURN(storage::JoinedMaps maps, Load(context, job));
  const MappingCamera camera = CameraFor(context, job);
  const KeyFrameId last_of_target = maps.target.last_keyframe_id;

  progress.Enter("looking for common places");
  const PlaceMemory places = RememberPlaces(context, maps.map);
  SEMMAP_ASSIGN_OR_RETURN(const MapOverlap overlap,
                          FindOverlap(context.slam, camera, places, maps.map, last_of_target,
                                      ReportPart(progress, kMergeLoaded, kFound)));
  if (!overlap.IsSound(context.slam.merge)) return DoNotOverlap(overlap);

  progress.Enter("joining");
  const bool with_scale = !maps.target.scale_known && !maps.source.scale_known;
  MapJoiner joiner(context.slam, camera, overlap, last_of_target, with_scale, &maps.map);
  joiner.Align(progress.cancel_flag());
  const int fused = joiner.Fuse(ReportPart(progress, kFound, kFused));
  SEMMAP_RETURN_IF_ERROR(CheckCancelled(progress));
  auto response = std::make_unique<v1::MergeMapsResponse>();
  storage::MapInfo result = maps.target;
  if (!job.validate_only) {
    progress.Enter("adjusting");
    joiner.Adjust(progress.cancel_flag());
    SEMMAP_RETURN_IF_ERROR(CheckCancelled(progress));
    SEMMAP_ASSIGN_OR_RETURN(result, Store(context, job, overlap.target_from_source, &maps, progress));
    spdlog::info("maps joined target={} source={} links={} fused={} keyframes={} points={}", job.target.name,
                 job.source.name, overlap.links.size(), fused, result.keyframe_count, result.point_count);
  }
  Describe(overlap, fused, joiner, response.get());
  *response->mutable_map() = ToProto(result);
  return response;
}

// Everything that can be refused at once is.
absl::StatusOr<MergeJob> Prepare(const ServiceContext& context, const v1::MergeMapsRequest& request) {
  MergeJob job;
  SEMMAP_ASSIGN_OR_RETURN(job.target, FindMap(context, "target", request.target()));
  SEMMAP_ASSIGN_OR_RETURN(job.source, FindMap(context, "source", request.source()));
  if (job.target.id == job.source.id)
    return Error(v1::ERROR_REASON_FIELD_INVALID, "a map is not joined to itself", {{"field", "source"}});
  job.delete_source = request.delete_source();
  job.validate_only = request.validate_only();
  SEMMAP_RETURN_IF_ERROR(RequireUnused(context, job.target.name));
  SEMMAP_RETURN_IF_ERROR(RequireUnused(context, job.source.name));
  SEMMAP_RETURN_IF_ERROR(CheckNotEmpty(job.target));
  SEMMAP_RETURN_IF_ERROR(CheckNotEmpty(job.source));
  SEMMAP_RETURN_IF_ERROR(CheckCameras(job.target, job.source));
  if (context.vocabulary == nullptr) return NotImplemented("MergeMaps without a vocabulary");
  if (!job.validate_only) {
    SEMMAP_ASSIGN_OR_RETURN(job.hold, context.sessions->Hold({job.target.name, job.source.name}));
  }
  return job;
}

}  // namespace

absl::StatusOr<v1::Operation> MergeMaps(const ServiceContext& context, const v1::MergeMapsRequest& request) {
  return StartOperation(context, "MergeMaps", request.request_id(), [&]() -> absl::StatusOr<v1::Operation> {
    SEMMAP_ASSIGN_OR_RETURN(MergeJob job, Prepare(context, request));
    const std::vector<std::string> names = {job.target.name, job.source.name};
    return context.operations->Start(v1::OPERATION_KIND_MERGE, names,
                                     [context, job = std::move(job)](OperationProgress& progress) {
                                       return Merge(context, job, progress);
                                     });
  });
}

}  // namespace semmap::server
