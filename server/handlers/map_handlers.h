#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "google/protobuf/empty.pb.h"
#include "semmap/v1/map_service.pb.h"
#include "server/geo_frame.h"
#include "server/handlers/chunk_source.h"
#include "server/service_context.h"

// MapService, one function and file for each call; behaviour and errors are those of the contract. They talk
// to the store and may take a while; they know no network. Thread-safe.
namespace semmap::server {

absl::StatusOr<v1::Map> CreateMap(const ServiceContext& context, const v1::CreateMapRequest& request);
absl::StatusOr<v1::Map> GetMap(const ServiceContext& context, const v1::GetMapRequest& request);
absl::StatusOr<v1::ListMapsResponse> ListMaps(const ServiceContext& context,
                                              const v1::ListMapsRequest& request);
absl::StatusOr<v1::Map> UpdateMap(const ServiceContext& context, const v1::UpdateMapRequest& request);
absl::StatusOr<google::protobuf::Empty> DeleteMap(const ServiceContext& context,
                                                  const v1::DeleteMapRequest& request);
absl::StatusOr<v1::Map> RenameMap(const ServiceContext& context, const v1::RenameMapRequest& request);
absl::StatusOr<v1::Operation> CopyMap(const ServiceContext& context, const v1::CopyMapRequest& request);
absl::StatusOr<v1::Operation> CheckMap(const ServiceContext& context, const v1::CheckMapRequest& request);
absl::StatusOr<v1::Operation> RepairMap(const ServiceContext& context, const v1::RepairMapRequest& request);
absl::StatusOr<v1::Operation> MergeMaps(const ServiceContext& context, const v1::MergeMapsRequest& request);
absl::StatusOr<v1::Operation> OptimizeMap(const ServiceContext& context,
                                          const v1::OptimizeMapRequest& request);
absl::StatusOr<v1::Operation> PruneMap(const ServiceContext& context, const v1::PruneMapRequest& request);
absl::StatusOr<v1::Operation> ExportMap(const ServiceContext& context, const v1::ExportMapRequest& request);
absl::StatusOr<v1::MapSummary> GetMapSummary(const ServiceContext& context,
                                             const v1::GetMapSummaryRequest& request);
absl::StatusOr<v1::QueryKeyFramesResponse> QueryKeyFrames(const ServiceContext& context,
                                                          const v1::QueryKeyFramesRequest& request);

// What a bad request is refused for is found when the source is made.
absl::StatusOr<std::unique_ptr<ChunkSource<v1::QueryMapPointsResponse>>> QueryMapPoints(
    const ServiceContext& context, const v1::QueryMapPointsRequest& request);
absl::StatusOr<std::unique_ptr<ChunkSource<v1::GetTrajectoryResponse>>> GetTrajectory(
    const ServiceContext& context, const v1::GetTrajectoryRequest& request);

absl::StatusOr<std::unique_ptr<ChunkSource<v1::ReadArtifactResponse>>> ReadArtifact(
    const ServiceContext& context, const v1::ReadArtifactRequest& request);

// MAP_IN_USE while a session runs on the map, or an operation keeps sessions off it.
absl::Status RequireUnused(const ServiceContext& context, const std::string& map_id);
// MAP_NOT_ANCHORED.
absl::StatusOr<GeoFrame> GeoFrameOf(const storage::MapInfo& map);
// The map that a well-formed name stands for: NAME_INVALID, MAP_NOT_FOUND, and the store's own.
absl::StatusOr<storage::MapInfo> FindMap(const ServiceContext& context, const char* field,
                                         const std::string& name);
// A session of that map: NAME_INVALID, SESSION_NOT_FOUND, and the store's own.
absl::StatusOr<storage::SessionId> FindSession(const ServiceContext& context, const storage::MapInfo& map,
                                               const std::string& name);

}  // namespace semmap::server
