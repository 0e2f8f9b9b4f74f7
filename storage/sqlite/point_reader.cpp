// The part of point_rows.h that reads.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/appearance_codec.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/spatial_index.h"

namespace semmap::storage::sqlite {
namespace {

// Beyond this many cells or points that may be in a box, all rows are scanned instead: the list stays below
// 32 MB.
constexpr size_t kMaxCandidates = size_t{1} << 22;

#define SEMMAP_POINT_COLUMNS                                                                        \
  "point_id, x, y, z, semantic_class, class_confidence, observation_count, first_seen, last_seen, " \
  "reference_keyframe_id, appearance, cell_key"
constexpr char kSelectOne[] = "SELECT " SEMMAP_POINT_COLUMNS " FROM points WHERE point_key = ?";
constexpr char kSelectRange[] =
    "SELECT " SEMMAP_POINT_COLUMNS " FROM points WHERE point_key BETWEEN ? AND ? ORDER BY point_key";
constexpr char kSelectInCell[] = "SELECT point_id FROM points WHERE map_id = ? AND cell_key = ?";

// What can be told from the columns, before the rest is decoded.
bool Matches(const MapPointQuery& query, const Query& row) {
  if (query.box.has_value() && !query.box->contains(Eigen::Vector3d(row.Real(1), row.Real(2), row.Real(3)))) {
    return false;
  }
  if (row.Real(5) < static_cast<double>(query.min_confidence)) return false;
  if (row.Int(6) < static_cast<int64_t>(query.min_observations)) return false;
  if (query.seen.has_value() && (row.Int(7) >= query.seen->end || row.Int(8) < query.seen->begin))
    return false;
  return query.classes.empty() ||
         std::find(query.classes.begin(), query.classes.end(), row.Int(4)) != query.classes.end();
}

// Hands matching points to the visitor, as many as the query wants.
class Delivery {
 public:
  Delivery(const MapPointQuery& query, const MapPointVisitor& visit) : query_(query), visit_(visit) {}

  // False: the query is answered.
  absl::StatusOr<bool> Offer(const Query& row) {
    if (!Matches(query_, row)) return true;
    SEMMAP_RETURN_IF_ERROR(ReadPointRow(row, &point_));
    return visit_(point_) && (query_.limit == 0 || ++delivered_ < query_.limit);
  }

 private:
  const MapPointQuery& query_;
  const MapPointVisitor& visit_;
  MapPointRecord point_;
  size_t delivered_ = 0;
};

// Ids behind `after` of the points in all cells that meet the box, ascending; nullopt when they are too many
// to list.
absl::StatusOr<std::optional<std::vector<uint64_t>>> FindCandidates(Connection& connection, MapId map,
                                                                    const Eigen::AlignedBox3d& box,
                                                                    MapPointId after) {
  SEMMAP_ASSIGN_OR_RETURN(const MapPlacement placement, ReadPlacement(connection, map));
  if (placement.cell_size == 0) return std::vector<uint64_t>();
  SEMMAP_ASSIGN_OR_RETURN(const auto cells,
                          FindPointCells(connection, map, box, placement.cell_size, kMaxCandidates));
  if (!cells.has_value()) return std::nullopt;
  std::vector<uint64_t> ids;
  Query select(connection, kSelectInCell);
  for (const int64_t cell : *cells) {
    select.Bind(map).Bind(cell);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
      if (!row) break;
      if (select.Unsigned(0) > after.value()) ids.push_back(select.Unsigned(0));
    }
    if (ids.size() > kMaxCandidates) return std::nullopt;
    select.Reset();
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

absl::Status VisitAll(Connection& connection, MapId map, MapPointId after, Delivery* delivery) {
  Query rows(connection, kSelectAllPoints);
  BindPointsBehind(rows, map, after);
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
    if (!row) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(const bool more, delivery->Offer(rows));
    if (!more) return absl::OkStatus();
  }
}

absl::Status VisitCandidates(Connection& connection, MapId map, std::span<const uint64_t> ids,
                             Delivery* delivery) {
  Query select(connection, kSelectOne);
  for (const uint64_t id : ids) {
    select.Bind(PointKey(map, MapPointId(id)));
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (row) {
      SEMMAP_ASSIGN_OR_RETURN(const bool more, delivery->Offer(select));
      if (!more) return absl::OkStatus();
    }
    select.Reset();
  }
  return absl::OkStatus();
}

}  // namespace

extern const char kSelectAllPoints[] =
    "SELECT " SEMMAP_POINT_COLUMNS " FROM points WHERE point_key > ? AND point_key < ? ORDER BY point_key";
#undef SEMMAP_POINT_COLUMNS

absl::Status ReadPointRow(const Query& row, MapPointRecord* point) {
  point->id = row.IdAt<MapPointId>(0);
  point->position_in_map = {row.Real(1), row.Real(2), row.Real(3)};
  point->semantic_class = static_cast<uint8_t>(row.Int(4));
  point->class_confidence = static_cast<float>(row.Real(5));
  point->observation_count = static_cast<uint32_t>(row.Int(6));
  point->first_seen = row.Int(7);
  point->last_seen = row.Int(8);
  point->reference_keyframe = row.IdAt<KeyFrameId>(9);
  if (row.Int(4) != point->semantic_class || row.Int(6) != point->observation_count) {
    return absl::DataLossError(
        absl::StrCat("map point ", point->id.value(), ": class or count out of range"));
  }
  const absl::Status appearance = DecodeAppearance(row.Bytes(10), point);
  if (appearance.ok()) return appearance;
  return absl::DataLossError(absl::StrCat("map point ", point->id.value(), ": ", appearance.message()));
}

void BindPointsBehind(Query& rows, MapId map, MapPointId after) {
  rows.Bind(PointKey(map, after)).Bind(PointKey(MapId(map.value() + 1), MapPointId()));
}

int64_t CellKeyOfRow(const Query& row) { return row.Int(11); }

absl::Status VisitPoints(Connection& connection, MapId map, const MapPointQuery& query,
                         const MapPointVisitor& visit) {
  Delivery delivery(query, visit);
  if (!query.box.has_value()) return VisitAll(connection, map, query.after, &delivery);
  SEMMAP_ASSIGN_OR_RETURN(const auto candidates, FindCandidates(connection, map, *query.box, query.after));
  return candidates.has_value() ? VisitCandidates(connection, map, *candidates, &delivery)
                                : VisitAll(connection, map, query.after, &delivery);
}

absl::StatusOr<std::vector<MapPointRecord>> ReadPoints(Connection& connection, MapId map,
                                                       std::span<const MapPointId> ids) {
  std::vector<MapPointRecord> points;
  points.reserve(ids.size());
  Query select(connection, kSelectOne);
  for (const MapPointId id : ids) {
    select.Bind(PointKey(map, id));
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (row) SEMMAP_RETURN_IF_ERROR(ReadPointRow(select, &points.emplace_back()));
    select.Reset();
  }
  return points;
}

absl::Status VisitPointRange(Connection& connection, MapId map, MapPointId first, MapPointId last,
                             absl::FunctionRef<void(const MapPointRecord&)> visit) {
  Query rows(connection, kSelectRange);
  rows.Bind(PointKey(map, first)).Bind(PointKey(map, last));
  MapPointRecord point;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, rows.Step());
    if (!row) return absl::OkStatus();
    SEMMAP_RETURN_IF_ERROR(ReadPointRow(rows, &point));
    visit(point);
  }
}

}  // namespace semmap::storage::sqlite
