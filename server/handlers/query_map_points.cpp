#include "server/area_filter.h"
#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/map_conversion.h"
#include "slam/common/status_macros.h"
#include "slam/semantics/taxonomy.h"

namespace semmap::server {
namespace {

constexpr int kMaxClasses = 256;

absl::Status FieldInvalid(const char* field, const char* what) {
  return Error(v1::ERROR_REASON_FIELD_INVALID, std::string(field) + " " + what, {{"field", field}});
}

// Which of the optional columns are wanted.
struct Columns {
  bool classes = false;
  bool confidences = false;
  bool observation_counts = false;
  bool first_seen = false;
  bool last_seen = false;
  bool normals = false;
};

absl::StatusOr<Columns> ReadColumns(const google::protobuf::FieldMask& mask) {
  if (mask.paths().empty()) return Columns{true, true, true, true, true, true};
  Columns columns;
  for (const std::string& path : mask.paths()) {
    if (path == "semantic_classes")
      columns.classes = true;
    else if (path == "class_confidences")
      columns.confidences = true;
    else if (path == "observation_counts")
      columns.observation_counts = true;
    else if (path == "first_seen_ns")
      columns.first_seen = true;
    else if (path == "last_seen_ns")
      columns.last_seen = true;
    else if (path == "normals")
      columns.normals = true;
    else if (path != "ids" && path != "positions")
      return FieldInvalid("columns", "names no column of MapPointColumns");
  }
  return columns;
}

void AppendPoint(const MapPointRecord& point, const Columns& columns, v1::MapPointColumns* out) {
  out->add_ids(point.id.value());
  for (const double coordinate :
       {point.position_in_map.x(), point.position_in_map.y(), point.position_in_map.z()}) {
    out->add_positions(coordinate);
  }
  if (columns.classes) out->add_semantic_classes(point.semantic_class);
  if (columns.confidences) out->add_class_confidences(point.class_confidence);
  if (columns.observation_counts) out->add_observation_counts(point.observation_count);
  if (columns.first_seen) out->add_first_seen_ns(point.first_seen);
  if (columns.last_seen) out->add_last_seen_ns(point.last_seen);
  if (!columns.normals) return;
  for (const float coordinate : {point.normal.x(), point.normal.y(), point.normal.z()})
    out->add_normals(coordinate);
}

absl::Status ReadClasses(const v1::MapPointFilter& filter, storage::MapPointQuery* query) {
  if (filter.semantic_classes_size() > kMaxClasses)
    return FieldInvalid("filter.semantic_classes", "has too many");
  for (const uint32_t semantic_class : filter.semantic_classes()) {
    if (semantic_class > 255) return FieldInvalid("filter.semantic_classes", "must be at most 255");
    query->classes.push_back(static_cast<uint8_t>(semantic_class));
  }
  return absl::OkStatus();
}

absl::StatusOr<storage::MapPointQuery> ReadQuery(const v1::MapPointFilter& filter) {
  storage::MapPointQuery query;
  SEMMAP_RETURN_IF_ERROR(ReadClasses(filter, &query));
  if (!(filter.min_class_confidence() >= 0 && filter.min_class_confidence() <= 1)) {
    return FieldInvalid("filter.min_class_confidence", "must be between 0 and 1");
  }
  if (filter.min_observations() < 0) return FieldInvalid("filter.min_observations", "must not be negative");
  query.min_confidence = static_cast<float>(filter.min_class_confidence());
  query.min_observations = static_cast<uint32_t>(filter.min_observations());
  if (filter.has_seen()) {
    SEMMAP_ASSIGN_OR_RETURN(query.seen, FromProto(filter.seen()));
  }
  return query;
}

bool IsActive(uint8_t semantic_class) {
  static const ClassSet inactive(kInactiveClasses);
  return !inactive.Contains(semantic_class);
}

class PointSource : public ChunkSource<v1::QueryMapPointsResponse> {
 public:
  struct Parameters {
    storage::MapId map;
    storage::MapPointQuery query;
    AreaFilter area;
    Columns columns;
    bool active_only = false;
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
      parameters_.query.after = point.id;
      if (IsWanted(point)) AppendPoint(point, parameters_.columns, points);
      return points->ids_size() < chunk;
    };
    const storage::MapPointQuery query = parameters_.query;
    SEMMAP_RETURN_IF_ERROR(FromStore(context_.store->ForEachMapPoint(parameters_.map, query, visit)));
    parameters_.remaining = points->ids_size() < chunk ? 0 : parameters_.remaining - chunk;
    return points->ids_size() > 0;
  }

 private:
  bool IsWanted(const MapPointRecord& point) const {
    return parameters_.area.Contains(point.position_in_map) &&
           (!parameters_.active_only || IsActive(point.semantic_class));
  }

  const ServiceContext& context_;
  Parameters parameters_;
};

absl::Status CheckRequest(const v1::QueryMapPointsRequest& request) {
  if (request.limit() < 0) return FieldInvalid("limit", "must not be negative");
  const bool geographic = request.coordinates() == v1::COORDINATES_WGS84;
  return geographic ? NotImplemented("COORDINATES_WGS84") : absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<ChunkSource<v1::QueryMapPointsResponse>>> QueryMapPoints(
    const ServiceContext& context, const v1::QueryMapPointsRequest& request) {
  SEMMAP_RETURN_IF_ERROR(CheckRequest(request));
  PointSource::Parameters parameters;
  SEMMAP_ASSIGN_OR_RETURN(parameters.query, ReadQuery(request.filter()));
  SEMMAP_ASSIGN_OR_RETURN(parameters.area, FromProto(request.filter().area()));
  SEMMAP_ASSIGN_OR_RETURN(parameters.columns, ReadColumns(request.columns()));
  SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo map, FindMap(context, "map", request.map()));
  parameters.map = map.id;
  parameters.query.box = parameters.area.box;
  parameters.active_only = request.filter().active_only();
  parameters.remaining = request.limit() == 0 ? std::numeric_limits<int64_t>::max() : request.limit();
  return std::make_unique<PointSource>(context, std::move(parameters));
}

}  // namespace semmap::server
