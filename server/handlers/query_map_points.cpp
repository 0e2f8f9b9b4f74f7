#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "server/error_reasons.h"
#include "server/geo_frame.h"
#include "server/handlers/map_handlers.h"
#include "server/nearest.h"
#include "server/point_columns.h"
#include "server/point_filter.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

class PointSource : public ChunkSource<v1::QueryMapPointsResponse> {
 public:
  struct Parameters {
    storage::MapId map;
    PointFilter filter;
    std::optional<GeoFrame> geographic;  // the coordinates to answer in; else the map's
    PointColumns columns;
    int64_t remaining = 0;  // points still to send
  };

  PointSource(const ServiceContext& context, Parameters parameters)
      : context_(context), parameters_(std::move(parameters)) {}

  absl::StatusOr<bool> Next(v1::QueryMapPointsResponse* response) override {
    const int64_t chunk = std::min<int64_t>(context_.config.query_chunk, parameters_.remaining);
    if (chunk == 0) return false;
    const auto map = context_.store->GetMap(parameters_.map);
    if (!map.ok()) return FromStore(map.status());
    response->set_map_version(map->version);
    v1::MapPointColumns* points = response->mutable_points();
    const auto visit = [&](const MapPointRecord& point) {
      parameters_.filter.query.after = point.id;
      if (parameters_.filter.Contains(point)) {
        AppendPoint(point, PositionOf(point), parameters_.columns, points);
      }
      return points->ids_size() < chunk;
    };
    const storage::MapPointQuery query = parameters_.filter.query;
    SEMMAP_RETURN_IF_ERROR(FromStore(context_.store->ForEachMapPoint(parameters_.map, query, visit)));
    parameters_.remaining = points->ids_size() < chunk ? 0 : parameters_.remaining - chunk;
    return points->ids_size() > 0;
  }

 private:
  Eigen::Vector3d PositionOf(const MapPointRecord& point) const {
    const auto& geographic = parameters_.geographic;
    return geographic.has_value() ? geographic->ToGeographic(point.position_in_map) : point.position_in_map;
  }

  const ServiceContext& context_;
  Parameters parameters_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<ChunkSource<v1::QueryMapPointsResponse>>> QueryMapPoints(
    const ServiceContext& context, const v1::QueryMapPointsRequest& request) {
  if (request.limit() < 0) return FieldInvalid("limit", "must not be negative");
  PointSource::Parameters parameters;
  SEMMAP_ASSIGN_OR_RETURN(parameters.filter, FromProto(request.filter()));
  SEMMAP_ASSIGN_OR_RETURN(parameters.columns, ReadColumns(request.columns()));
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "map", request.map()));
  parameters.map = map.id;
  SEMMAP_RETURN_IF_ERROR(ResolveNearest(*context.store, map.id, &parameters.filter));
  if (request.coordinates() == v1::COORDINATES_WGS84) {
    SEMMAP_ASSIGN_OR_RETURN(parameters.geographic, GeoFrameOf(map));
  }
  parameters.remaining = request.limit() == 0 ? std::numeric_limits<int64_t>::max() : request.limit();
  return std::make_unique<PointSource>(context, std::move(parameters));
}

}  // namespace semmap::server
