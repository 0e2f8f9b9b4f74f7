#include "semmap/v1/map_service.grpc.pb.h"
#include "server/handlers/map_handlers.h"
#include "server/rpc/import_call.h"
#include "server/rpc/services.h"
#include "server/rpc/streamed_call.h"
#include "server/rpc/unary_call.h"
#include "server/rpc/watch_call.h"

namespace semmap::server {
namespace {

using Call = grpc::CallbackServerContext;
using Unary = grpc::ServerUnaryReactor;

class MapService : public v1::MapService::CallbackService {
 public:
  explicit MapService(CallRunner* runner) : runner_(*runner) {}

  Unary* CreateMap(Call* call, const v1::CreateMapRequest* request, v1::Map* response) override {
    return RunUnary(runner_, call, request, response, &server::CreateMap);
  }
  Unary* GetMap(Call* call, const v1::GetMapRequest* request, v1::Map* response) override {
    return RunUnary(runner_, call, request, response, &server::GetMap);
  }
  Unary* ListMaps(Call* call, const v1::ListMapsRequest* request, v1::ListMapsResponse* response) override {
    return RunUnary(runner_, call, request, response, &server::ListMaps);
  }
  Unary* UpdateMap(Call* call, const v1::UpdateMapRequest* request, v1::Map* response) override {
    return RunUnary(runner_, call, request, response, &server::UpdateMap);
  }
  Unary* DeleteMap(Call* call, const v1::DeleteMapRequest* request,
                   google::protobuf::Empty* response) override {
    return RunUnary(runner_, call, request, response, &server::DeleteMap);
  }
  Unary* RenameMap(Call* call, const v1::RenameMapRequest* request, v1::Map* response) override {
    return RunUnary(runner_, call, request, response, &server::RenameMap);
  }
  Unary* CopyMap(Call* call, const v1::CopyMapRequest* request, v1::Operation* response) override {
    return RunUnary(runner_, call, request, response, &server::CopyMap);
  }
  Unary* CheckMap(Call* call, const v1::CheckMapRequest* request, v1::Operation* response) override {
    return RunUnary(runner_, call, request, response, &server::CheckMap);
  }
  Unary* RepairMap(Call* call, const v1::RepairMapRequest* request, v1::Operation* response) override {
    return RunUnary(runner_, call, request, response, &server::RepairMap);
  }
  Unary* ExportMap(Call* call, const v1::ExportMapRequest* request, v1::Operation* response) override {
    return RunUnary(runner_, call, request, response, &server::ExportMap);
  }
  Unary* GetMapSummary(Call* call, const v1::GetMapSummaryRequest* request,
                       v1::MapSummary* response) override {
    return RunUnary(runner_, call, request, response, &server::GetMapSummary);
  }
  Unary* QueryKeyFrames(Call* call, const v1::QueryKeyFramesRequest* request,
                        v1::QueryKeyFramesResponse* response) override {
    return RunUnary(runner_, call, request, response, &server::QueryKeyFrames);
  }
  grpc::ServerWriteReactor<v1::QueryMapPointsResponse>* QueryMapPoints(
      Call* call, const v1::QueryMapPointsRequest* request) override {
    return new StreamedCall<v1::QueryMapPointsRequest, v1::QueryMapPointsResponse>(  // NOLINT: deletes itself
        runner_, call, request, &server::QueryMapPoints);
  }
  grpc::ServerWriteReactor<v1::GetTrajectoryResponse>* GetTrajectory(
      Call* call, const v1::GetTrajectoryRequest* request) override {
    return new StreamedCall<v1::GetTrajectoryRequest, v1::GetTrajectoryResponse>(  // NOLINT: deletes itself
        runner_, call, request, &server::GetTrajectory);
  }
  grpc::ServerWriteReactor<v1::ReadArtifactResponse>* ReadArtifact(
      Call* call, const v1::ReadArtifactRequest* request) override {
    return new StreamedCall<v1::ReadArtifactRequest, v1::ReadArtifactResponse>(  // NOLINT: deletes itself
        runner_, call, request, &server::ReadArtifact);
  }
  grpc::ServerWriteReactor<v1::WatchMapResponse>* WatchMap(Call*,
                                                           const v1::WatchMapRequest* request) override {
    return WatchCall::Start(runner_, request);
  }
  grpc::ServerReadReactor<v1::ImportMapRequest>* ImportMap(Call* call, v1::Operation* response) override {
    return ImportCall::Start(runner_, call, response);
  }
  Unary* MergeMaps(Call* call, const v1::MergeMapsRequest* request, v1::Operation* response) override {
    return RunUnary(runner_, call, request, response, &server::MergeMaps);
  }
  Unary* OptimizeMap(Call* call, const v1::OptimizeMapRequest* request, v1::Operation* response) override {
    return RunUnary(runner_, call, request, response, &server::OptimizeMap);
  }
  Unary* PruneMap(Call* call, const v1::PruneMapRequest* request, v1::Operation* response) override {
    return RunUnary(runner_, call, request, response, &server::PruneMap);
  }

 private:
  CallRunner& runner_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeMapService(CallRunner* runner) {
  return std::make_unique<MapService>(runner);
}

}  // namespace semmap::server
