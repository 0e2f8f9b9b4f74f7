// The part of point_rows.h that writes.
#include "slam/common/status_macros.h"
#include "storage/appearance_codec.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/spatial_index.h"

namespace semmap::storage::sqlite {
namespace {

#define SEMMAP_SET_POINT                                                                   \
  "UPDATE points SET x = ?1, y = ?2, z = ?3, semantic_class = ?4, class_confidence = ?5, " \
  "observation_count = ?6, first_seen = ?7, last_seen = ?8, reference_keyframe_id = ?9, appearance = ?10"
// Leaves the index on cells alone.
constexpr char kUpdateInCell[] = SEMMAP_SET_POINT " WHERE point_key = ?11 AND cell_key = ?12";
constexpr char kUpdateAndMove[] = SEMMAP_SET_POINT ", cell_key = ?12 WHERE point_key = ?11";
#undef SEMMAP_SET_POINT
constexpr char kInsert[] =
    "INSERT INTO points (x, y, z, semantic_class, class_confidence, observation_count, first_seen, "
    "last_seen, "
    "reference_keyframe_id, appearance, point_key, cell_key, session_id) "
    "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (point_key) DO NOTHING";
constexpr char kDelete[] = "DELETE FROM points WHERE point_key = ?";
constexpr char kDeleteOfSession[] =
    "DELETE FROM points WHERE point_key > ? AND point_key < ? AND session_id = ?";

}  // namespace

absl::StatusOr<bool> PointWriter::Execute(const char* sql, const MapPointRecord& point, int64_t cell_key,
                                          bool with_session) {
  const Eigen::Vector3d& position = point.position_in_map;
  Query query(connection_, sql);
  query.Bind(position.x()).Bind(position.y()).Bind(position.z());
  query.Bind(point.semantic_class).Bind(static_cast<double>(point.class_confidence));
  query.Bind(point.observation_count).Bind(point.first_seen).Bind(point.last_seen);
  query.Bind(point.reference_keyframe).BindBlob(buffer_.view());
  query.Bind(PointKey(map_, point.id)).Bind(cell_key);
  if (with_session) query.Bind(session_);
  SEMMAP_RETURN_IF_ERROR(query.Run());
  return connection_.changes() > 0;
}

absl::Status PointWriter::AddCell(const Cell& cell) {
  if (!known_cells_.insert(PackCell(cell)).second) return absl::OkStatus();
  return AddPointCell(connection_, map_, cell);
}

absl::StatusOr<bool> PointWriter::Upsert(const MapPointRecord& point) {
  EncodeAppearance(point, &buffer_);
  const Cell cell = CellOf(point.position_in_map, placement_.cell_size);
  const int64_t cell_key = PackCell(cell);
  // The common cases take one statement each: a point that is new for certain, and one that stays in its
  // cell.
  if (point.id <= placement_.last_point_id) {
    SEMMAP_ASSIGN_OR_RETURN(const bool updated, Execute(kUpdateInCell, point, cell_key, false));
    if (updated) return false;
  }
  SEMMAP_RETURN_IF_ERROR(AddCell(cell));
  SEMMAP_ASSIGN_OR_RETURN(const bool inserted, Execute(kInsert, point, cell_key, true));
  if (inserted) return true;
  SEMMAP_RETURN_IF_ERROR(Execute(kUpdateAndMove, point, cell_key, false).status());
  return false;
}

absl::StatusOr<bool> ErasePoint(Connection& connection, MapId map, MapPointId point) {
  SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kDelete, PointKey(map, point)));
  return connection.changes() > 0;
}

absl::StatusOr<int64_t> ErasePointsOf(Connection& connection, MapId map, SessionId session) {
  Query remove(connection, kDeleteOfSession);
  BindPointsBehind(remove, map, MapPointId());
  SEMMAP_RETURN_IF_ERROR(remove.Bind(session).Run());
  return connection.changes();
}

}  // namespace semmap::storage::sqlite
