#include "storage/sqlite/spatial_index.h"

#include <algorithm>

#include "slam/common/status_macros.h"
#include "storage/sqlite/query.h"
#include "storage/validation.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kPutKeyFrame[] = "INSERT OR REPLACE INTO keyframe_cells VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)";
constexpr char kEraseKeyFrame[] = "DELETE FROM keyframe_cells WHERE id = ?";
constexpr char kGetKeyFrame[] = "SELECT x_min, y_min, z_min FROM keyframe_cells WHERE id = ?";
// A cell c covers [c, c + 1): strictly more than the box's first cell at its upper end.
#define SEMMAP_MEETS_BOX                                                                            \
  " WHERE map_min >= ? AND map_max <= ? AND x_max > ? AND x_min <= ? AND y_max > ? AND y_min <= ? " \
  "AND z_max > ? AND z_min <= ? LIMIT ?"
constexpr char kFindKeyFrames[] = "SELECT id FROM keyframe_cells" SEMMAP_MEETS_BOX;
constexpr char kFindPointCells[] = "SELECT x_min, y_min, z_min FROM point_cells" SEMMAP_MEETS_BOX;
#undef SEMMAP_MEETS_BOX
constexpr char kAddPointCell[] = "INSERT INTO point_cells VALUES (NULL, ?, ?, ?, ?, ?, ?, ?, ?)";
constexpr char kAllPointCells[] =
    "SELECT x_min, y_min, z_min FROM point_cells WHERE map_min >= ? AND map_max <= ?";
constexpr char kSomePointCells[] = "SELECT id FROM point_cells WHERE map_min >= ? AND map_max <= ? LIMIT ?";
constexpr char kErasePointCell[] = "DELETE FROM point_cells WHERE id = ?";

int64_t KeyOf(MapId map, KeyFrameId keyframe) {
  return static_cast<int64_t>(map.value() * kIdLimit + keyframe.value());
}

// The map is a dimension of the tree. In it, as in space, a box has an extent: the tree chooses by volume,
// and that of a box without extent is always nothing.
void BindMap(MapId map, Query* query) { query->Bind(2 * map.value()).Bind(2 * map.value() + 1); }

void BindExtent(const Cell& cell, Query* query) {
  for (const int coordinate : cell) query->Bind(coordinate).Bind(coordinate + 1);
}

void BindBox(MapId map, const Eigen::AlignedBox3d& box, double cell_size, size_t limit, Query* query) {
  const Cell first = CellOf(box.min(), cell_size);
  const Cell last = CellOf(box.max(), cell_size);
  BindMap(map, query);
  for (int axis = 0; axis < 3; ++axis) query->Bind(first[axis]).Bind(last[axis]);
  query->Bind(limit);
}

Cell CellAt(const Query& row) {
  return {static_cast<int>(row.Int(0)), static_cast<int>(row.Int(1)), static_cast<int>(row.Int(2))};
}

// All rows, each as read(row).
template <typename T, typename Read>
absl::StatusOr<std::vector<T>> Collect(Query* query, Read&& read) {
  std::vector<T> values;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, query->Step());
    if (!row) return values;
    values.push_back(read(*query));
  }
}

}  // namespace

absl::Status PutKeyFrameCell(Connection& connection, MapId map, KeyFrameId keyframe, const Cell& cell) {
  Query query(connection, kPutKeyFrame);
  query.Bind(KeyOf(map, keyframe));
  BindMap(map, &query);
  BindExtent(cell, &query);
  return query.Run();
}

absl::Status EraseKeyFrameCell(Connection& connection, MapId map, KeyFrameId keyframe) {
  return RunQuery(connection, kEraseKeyFrame, KeyOf(map, keyframe));
}

absl::StatusOr<std::optional<Cell>> GetKeyFrameCell(Connection& connection, MapId map, KeyFrameId keyframe) {
  Query query(connection, kGetKeyFrame);
  query.Bind(KeyOf(map, keyframe));
  SEMMAP_ASSIGN_OR_RETURN(const bool found, query.Step());
  return found ? std::optional<Cell>(CellAt(query)) : std::nullopt;
}

absl::StatusOr<std::optional<std::vector<uint64_t>>> FindKeyFrames(Connection& connection, MapId map,
                                                                   const Eigen::AlignedBox3d& box,
                                                                   size_t limit) {
  Query query(connection, kFindKeyFrames);
  BindBox(map, box, kKeyFrameCell, limit + 1, &query);
  SEMMAP_ASSIGN_OR_RETURN(std::vector<uint64_t> ids, Collect<uint64_t>(&query, [](const Query& row) {
                            return row.Unsigned(0) % kIdLimit;
                          }));
  if (ids.size() > limit) return std::nullopt;
  std::sort(ids.begin(), ids.end());
  return ids;
}

absl::Status AddPointCell(Connection& connection, MapId map, const Cell& cell) {
  {
    Query known(connection, kFindPointCells);
    BindMap(map, &known);
    for (const int coordinate : cell) known.Bind(coordinate).Bind(coordinate);
    SEMMAP_ASSIGN_OR_RETURN(const bool is_known, known.Bind(1).Step());
    if (is_known) return absl::OkStatus();
  }
  Query add(connection, kAddPointCell);
  BindMap(map, &add);
  BindExtent(cell, &add);
  return add.Run();
}

absl::StatusOr<std::optional<std::vector<int64_t>>> FindPointCells(Connection& connection, MapId map,
                                                                   const Eigen::AlignedBox3d& box,
                                                                   double cell_size, size_t limit) {
  Query query(connection, kFindPointCells);
  BindBox(map, box, cell_size, limit + 1, &query);
  SEMMAP_ASSIGN_OR_RETURN(std::vector<int64_t> keys,
                          Collect<int64_t>(&query, [](const Query& row) { return PackCell(CellAt(row)); }));
  if (keys.size() > limit) return std::nullopt;
  return keys;
}

absl::StatusOr<std::vector<int64_t>> AllPointCells(Connection& connection, MapId map) {
  Query query(connection, kAllPointCells);
  BindMap(map, &query);
  return Collect<int64_t>(&query, [](const Query& row) { return PackCell(CellAt(row)); });
}

absl::StatusOr<bool> ErasePointCells(Connection& connection, MapId map, int limit) {
  std::vector<int64_t> ids;
  {
    Query query(connection, kSomePointCells);
    BindMap(map, &query);
    query.Bind(limit);
    SEMMAP_ASSIGN_OR_RETURN(ids, Collect<int64_t>(&query, [](const Query& row) { return row.Int(0); }));
  }
  for (const int64_t id : ids) SEMMAP_RETURN_IF_ERROR(RunQuery(connection, kErasePointCell, id));
  return ids.empty();
}

}  // namespace semmap::storage::sqlite
