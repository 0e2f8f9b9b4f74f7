#pragma once

#include <span>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "storage/byte_buffer.h"
#include "storage/cell_grid.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/query.h"

// The rows of map points and the cells they are in. Writers run inside the caller's transaction.
namespace semmap::storage::sqlite {

// Writes points of one delta.
class PointWriter {
 public:
  PointWriter(Connection& connection, MapId map, SessionId session, const MapPlacement& placement)
      : connection_(connection), map_(map), session_(session), placement_(placement) {}

  // Replaces or adds the point; true when it was added.
  absl::StatusOr<bool> Upsert(const MapPointRecord& point);

 private:
  absl::StatusOr<bool> Execute(const char* sql, const MapPointRecord& point, int64_t cell_key,
                               bool with_session);
  absl::Status AddCell(const Cell& cell);

  Connection& connection_;
  const MapId map_;
  const SessionId session_;
  const MapPlacement placement_;
  // Neighbours share their cell: those that are in the tree for certain.
  absl::flat_hash_set<int64_t> known_cells_;
  ByteWriter buffer_;
};

// points.point_key.
inline int64_t PointKey(MapId map, MapPointId point) {
  return static_cast<int64_t>((map.value() << 40) | point.value());
}
// For "point_key > ? AND point_key < ?": the map's points with greater ids than `after`.
void BindPointsBehind(Query& rows, MapId map, MapPointId after);

// True when there was such a point.
absl::StatusOr<bool> ErasePoint(Connection& connection, MapId map, MapPointId point);
// Removes the points that the session added; returns how many.
absl::StatusOr<int64_t> ErasePointsOf(Connection& connection, MapId map, SessionId session);

absl::Status VisitPoints(Connection& connection, MapId map, const MapPointQuery& query,
                         const MapPointVisitor& visit);
absl::StatusOr<std::vector<MapPointRecord>> ReadPoints(Connection& connection, MapId map,
                                                       std::span<const MapPointId> ids);

// The points with ids in [first, last], ascending.
absl::Status VisitPointRange(Connection& connection, MapId map, MapPointId first, MapPointId last,
                             absl::FunctionRef<void(const MapPointRecord&)> visit);

// All rows in order of ids, for those that read every point whatever it holds: step `rows` and read each with
// ReadPointRow, which answers DATA_LOSS (with point->id set) for a row that cannot be.
extern const char kSelectAllPoints[];  // bind by BindPointsBehind
absl::Status ReadPointRow(const Query& row, MapPointRecord* point);
int64_t CellKeyOfRow(const Query& row);

}  // namespace semmap::storage::sqlite
