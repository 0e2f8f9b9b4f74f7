#include "storage/sqlite/point_rows.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/appearance_codec.h"
#include "storage/sqlite/spatial_index.h"

namespace semmap::storage::sqlite {
namespace {

// Beyond this many candidates of a box, the rows are scanned instead: the list of candidates stays below 32
// MB.
constexpr size_t kMaxCandidates = size_t{1} << 22;

constexpr char kSelectPosition[] = "SELECT x, y, z FROM points WHERE map_id = ? AND point_id = ?";
constexpr char kUpdate[] =
    "UPDATE points SET x = ?, y = ?, z = ?, semantic_class = ?, class_confidence = ?, observation_count = ?, "
    "first_seen = ?, last_seen = ?, reference_keyframe_id = ?, appearance = ? WHERE map_id = ? AND point_id "
    "= ?";
constexpr char kInsert[] =
    "INSERT INTO points (x, y, z, semantic_class, class_confidence, observation_count, first_seen, "
    "last_seen, "
    "reference_keyframe_id, appearance, map_id, point_id, session_id) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, "
    "?, ?, ?)";
constexpr char kDelete[] = "DELETE FROM points WHERE map_id = ? AND point_id = ?";
constexpr char kSelectOfSession[] = "SELECT point_id FROM points WHERE map_id = ? AND session_id = ?";
constexpr char kDeleteOfSession[] = "DELETE FROM points WHERE map_id = ? AND session_id = ?";
#define SEMMAP_POINT_COLUMNS                                                                        \
  "point_id, x, y, z, semantic_class, class_confidence, observation_count, first_seen, last_seen, " \
  "reference_keyframe_id, appearance"
constexpr char kSelectOne[] = "SELECT " SEMMAP_POINT_COLUMNS " FROM points WHERE map_id = ? AND point_id = ?";

Eigen::Vector3d PositionAt(const Query& row, int column) {
  return {row.Real(column), row.Real(column + 1), row.Real(column + 2)};
}

void BindPoint(const MapPointRecord& point, BlobView appearance, Query* query) {
  const Eigen::Vector3d& position = point.position_in_map;
  query->Bind(position.x()).Bind(position.y()).Bind(position.z());
  query->Bind(point.semantic_class).Bind(static_cast<double>(point.class_confidence));
  query->Bind(point.observation_count).Bind(point.first_seen).Bind(point.last_seen);
  query->Bind(point.reference_keyframe).BindBlob(appearance);
}

// What can be told from the columns, before the rest is decoded.
bool Matches(const MapPointQuery& query, const Query& row) {
  if (query.box.has_value() && !query.box->contains(PositionAt(row, 1))) return false;
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

absl::Status VisitAll(Connection& connection, MapId map, MapPointId after, Delivery* delivery) {
  Query rows(connection, kSelectAllPoints);
  rows.Bind(map).Bind(after);
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
    select.Bind(map).Bind(id);
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
    "SELECT " SEMMAP_POINT_COLUMNS " FROM points WHERE map_id = ? AND point_id > ? ORDER BY point_id";
#undef SEMMAP_POINT_COLUMNS

absl::Status ReadPointRow(const Query& row, MapPointRecord* point) {
  point->id = row.IdAt<MapPointId>(0);
  point->position_in_map = PositionAt(row, 1);
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

absl::StatusOr<bool> UpsertPoint(Connection& connection, MapId map, SessionId session,
                                 const MapPointRecord& point, ByteWriter* buffer) {
  EncodeAppearance(point, buffer);
  const Cell cell = CellOf(PointIndex(), point.position_in_map);
  bool is_new = true;
  bool moved = true;
  {
    Query select(connection, kSelectPosition);
    select.Bind(map).Bind(point.id);
    SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Step());
    is_new = !found;
    moved = is_new || CellOf(PointIndex(), PositionAt(select, 0)) != cell;
  }
  Query write(connection, is_new ? kInsert : kUpdate);
  BindPoint(point, buffer->view(), &write);
  write.Bind(map).Bind(point.id);
  if (is_new) write.Bind(session);
  SEMMAP_RETURN_IF_ERROR(write.Run());
  if (moved) SEMMAP_RETURN_IF_ERROR(PutCell(connection, PointIndex(), map, point.id.value(), cell));
  return is_new;
}

absl::StatusOr<bool> ErasePoint(Connection& connection, MapId map, MapPointId point) {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kDelete, map, point));
  if (connection.changes() == 0) return false;
  SEMMAP_RETURN_IF_ERROR(EraseCell(connection, PointIndex(), map, point.value()));
  return true;
}

absl::StatusOr<int64_t> ErasePointsOf(Connection& connection, MapId map, SessionId session) {
  {
    Query ids(connection, kSelectOfSession);
    ids.Bind(map).Bind(session);
    while (true) {
      SEMMAP_ASSIGN_OR_RETURN(const bool row, ids.Step());
      if (!row) break;
      SEMMAP_RETURN_IF_ERROR(EraseCell(connection, PointIndex(), map, ids.Unsigned(0)));
    }
  }
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kDeleteOfSession, map, session));
  return connection.changes();
}

absl::Status VisitPoints(Connection& connection, MapId map, const MapPointQuery& query,
                         const MapPointVisitor& visit) {
  Delivery delivery(query, visit);
  if (!query.box.has_value()) return VisitAll(connection, map, query.after, &delivery);
  SEMMAP_ASSIGN_OR_RETURN(const auto candidates,
                          FindCandidates(connection, PointIndex(), map, *query.box, kMaxCandidates));
  if (!candidates.has_value()) return VisitAll(connection, map, query.after, &delivery);
  const auto first = std::upper_bound(candidates->begin(), candidates->end(), query.after.value());
  return VisitCandidates(connection, map, std::span<const uint64_t>(first, candidates->end()), &delivery);
}

absl::StatusOr<std::vector<MapPointRecord>> ReadPoints(Connection& connection, MapId map,
                                                       std::span<const MapPointId> ids) {
  std::vector<MapPointRecord> points;
  points.reserve(ids.size());
  Query select(connection, kSelectOne);
  for (const MapPointId id : ids) {
    select.Bind(map).Bind(id);
    SEMMAP_ASSIGN_OR_RETURN(const bool row, select.Step());
    if (row) SEMMAP_RETURN_IF_ERROR(ReadPointRow(select, &points.emplace_back()));
    select.Reset();
  }
  return points;
}

}  // namespace semmap::storage::sqlite
