#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <utility>

#include "server/artifacts.h"
#include "server/error_reasons.h"
#include "server/geojson_file.h"
#include "server/handlers/map_handlers.h"
#include "server/handlers/start_operation.h"
#include "server/nearest.h"
#include "server/output_file.h"
#include "server/point_file.h"
#include "server/point_filter.h"
#include "server/session_conversion.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

// How often, in points, the work looks whether it is still wanted.
constexpr uint64_t kPointsBetweenReports = 1000;

absl::Status WritePoints(const ServiceContext& context, const storage::MapInfo& map, PointFilter filter,
                         const std::function<absl::Status(const MapPointRecord&)>& add,
                         OperationProgress& progress) {
  SEMMAP_RETURN_IF_ERROR(ResolveNearest(*context.store, map.id, &filter));
  uint64_t seen = 0;
  absl::Status status;
  const auto visit = [&](const MapPointRecord& point) {
    if (++seen % kPointsBetweenReports == 0) {
      progress.Report(static_cast<double>(seen) / static_cast<double>(std::max(map.point_count, seen)));
      if (progress.CancelRequested()) status = absl::CancelledError("the export was cancelled");
    }
    if (status.ok() && filter.Contains(point)) status = add(point);
    return status.ok();
  };
  SEMMAP_RETURN_IF_ERROR(FromStore(context.store->ForEachMapPoint(map.id, filter.query, visit)));
  return status;
}

absl::StatusOr<std::unique_ptr<google::protobuf::Message>> Publish(const ServiceContext& context,
                                                                   std::unique_ptr<PendingFile> file) {
  SEMMAP_ASSIGN_OR_RETURN(const Artifact artifact, context.artifacts->Publish(std::move(file)));
  context.timer->After(context.artifacts->lifetime(),
                       [artifacts = context.artifacts] { artifacts->RemoveExpired(); });
  auto response = std::make_unique<v1::ExportMapResponse>();
  response->set_artifact(ArtifactName(artifact.id));
  response->set_size_bytes(artifact.size_bytes);
  response->set_sha256(artifact.sha256);
  *response->mutable_expire_time() = ToTimestamp(artifact.expires_at);
  return response;
}

absl::StatusOr<std::unique_ptr<google::protobuf::Message>> ExportPoints(const ServiceContext& context,
                                                                        const storage::MapInfo& map,
                                                                        v1::MapFileFormat format,
                                                                        const PointFilter& filter,
                                                                        OperationProgress& progress) {
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<PendingFile> pending, context.artifacts->Begin());
  OutputFile output(pending.get());
  const std::unique_ptr<PointFile> points = MakePointFile(format, &output);
  const auto add = [&](const MapPointRecord& point) { return points->Add(point); };
  SEMMAP_RETURN_IF_ERROR(WritePoints(context, map, filter, add, progress));
  SEMMAP_RETURN_IF_ERROR(points->Finish());
  SEMMAP_RETURN_IF_ERROR(output.Close());
  return Publish(context, std::move(pending));
}

// The whole map as it is at one instant.
absl::StatusOr<std::unique_ptr<google::protobuf::Message>> ExportWhole(const ServiceContext& context,
                                                                       const storage::MapInfo& map,
                                                                       OperationProgress& progress) {
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<PendingFile> pending, context.artifacts->Begin());
  absl::Status space;
  const absl::Status written = context.store->ExportMap(map.id, pending->path(), [&](double share) {
    progress.Report(share);
    std::error_code ignored;
    const auto size = std::filesystem::file_size(pending->path() + ".part", ignored);
    if (!ignored) space = pending->GrowTo(static_cast<int64_t>(size));
    return space.ok() && !progress.CancelRequested();
  });
  SEMMAP_RETURN_IF_ERROR(space);
  if (absl::IsCancelled(written)) return written;
  SEMMAP_RETURN_IF_ERROR(FromStore(written));
  return Publish(context, std::move(pending));
}

absl::Status WriteTrajectories(const ServiceContext& context, const storage::MapInfo& map, GeoJsonFile* file,
                               OperationProgress& progress) {
  const auto sessions = context.store->ListSessions(map.id, storage::SessionId(), 0);
  if (!sessions.ok()) return FromStore(sessions.status());
  for (const storage::SessionInfo& session : *sessions) {
    absl::Status status;
    const auto visit = [&](const storage::TrajectoryPose& pose) {
      status = progress.CancelRequested()
                   ? absl::CancelledError("the export was cancelled")
                   : file->AddPosition(session.name, session.vehicle_id, pose.map_from_camera.translation());
      return status.ok();
    };
    storage::TrajectoryQuery query;
    query.session = session.id;
    SEMMAP_RETURN_IF_ERROR(FromStore(context.store->ForEachTrajectoryPose(map.id, query, visit)));
    SEMMAP_RETURN_IF_ERROR(status);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<google::protobuf::Message>> ExportGeographic(const ServiceContext& context,
                                                                            const storage::MapInfo& map,
                                                                            const PointFilter& filter,
                                                                            OperationProgress& progress) {
  SEMMAP_ASSIGN_OR_RETURN(const GeoFrame frame, GeoFrameOf(map));
  SEMMAP_ASSIGN_OR_RETURN(std::unique_ptr<PendingFile> pending, context.artifacts->Begin());
  OutputFile output(pending.get());
  GeoJsonFile file(&frame, &output);
  const auto add = [&](const MapPointRecord& point) { return file.AddPoint(point); };
  SEMMAP_RETURN_IF_ERROR(WritePoints(context, map, filter, add, progress));
  SEMMAP_RETURN_IF_ERROR(WriteTrajectories(context, map, &file, progress));
  SEMMAP_RETURN_IF_ERROR(file.Finish());
  SEMMAP_RETURN_IF_ERROR(output.Close());
  return Publish(context, std::move(pending));
}

absl::Status CheckFormat(v1::MapFileFormat format) {
  switch (format) {
    case v1::MAP_FILE_FORMAT_SEMMAP:
    case v1::MAP_FILE_FORMAT_PLY:
    case v1::MAP_FILE_FORMAT_PCD:
    case v1::MAP_FILE_FORMAT_CSV:
    case v1::MAP_FILE_FORMAT_GEOJSON:
      return absl::OkStatus();
    default:
      return Error(v1::ERROR_REASON_FIELD_INVALID, "the format is missing or not known",
                   {{"field", "format"}});
  }
}

}  // namespace

absl::StatusOr<v1::Operation> ExportMap(const ServiceContext& context, const v1::ExportMapRequest& request) {
  SEMMAP_RETURN_IF_ERROR(CheckFormat(request.format()));
  SEMMAP_ASSIGN_OR_RETURN(const PointFilter filter, FromProto(request.filter()));
  if (request.format() == v1::MAP_FILE_FORMAT_SEMMAP && request.filter().ByteSizeLong() > 0) {
    return Error(v1::ERROR_REASON_FIELD_INVALID, "a whole map cannot be filtered", {{"field", "filter"}});
  }
  return StartOperation(context, "ExportMap", request.request_id(), [&]() -> absl::StatusOr<v1::Operation> {
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "name", request.name()));
    if (request.format() == v1::MAP_FILE_FORMAT_GEOJSON) SEMMAP_RETURN_IF_ERROR(GeoFrameOf(map).status());
    return context.operations->Start(
        v1::OPERATION_KIND_EXPORT, {map.name},
        [context, map, format = request.format(), filter](OperationProgress& progress) {
          if (format == v1::MAP_FILE_FORMAT_SEMMAP) return ExportWhole(context, map, progress);
          if (format == v1::MAP_FILE_FORMAT_GEOJSON) return ExportGeographic(context, map, filter, progress);
          return ExportPoints(context, map, format, filter, progress);
        });
  });
}

}  // namespace semmap::server
