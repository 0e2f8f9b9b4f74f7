#include "storage/sqlite/spatial_index.h"

#include <algorithm>
#include <cmath>

#include "slam/common/status_macros.h"
#include "storage/sqlite/query.h"
#include "storage/validation.h"

namespace semmap::storage::sqlite {
namespace {

constexpr double kMaxCell = 1 << 30;

constexpr SpatialIndex kPointIndex{
    .cell_size = 0.25,
    .replace = "INSERT OR REPLACE INTO point_cells VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
    .erase = "DELETE FROM point_cells WHERE id = ?",
    .find =
        "SELECT id FROM point_cells WHERE map_min >= ? AND map_max <= ? AND x_max > ? AND x_min <= ? "
        "AND y_max > ? AND y_min <= ? AND z_max > ? AND z_min <= ? LIMIT ?",
    .get = "SELECT x_min, y_min, z_min FROM point_cells WHERE id = ?"};
constexpr SpatialIndex kKeyFrameIndex{
    .cell_size = 1.0,
    .replace = "INSERT OR REPLACE INTO keyframe_cells VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
    .erase = "DELETE FROM keyframe_cells WHERE id = ?",
    .find =
        "SELECT id FROM keyframe_cells WHERE map_min >= ? AND map_max <= ? AND x_max > ? AND x_min <= ? "
        "AND y_max > ? AND y_min <= ? AND z_max > ? AND z_min <= ? LIMIT ?",
    .get = "SELECT x_min, y_min, z_min FROM keyframe_cells WHERE id = ?"};

int64_t KeyOf(MapId map, uint64_t id) { return static_cast<int64_t>(map.value() * kIdLimit + id); }

int CellCoordinate(double value, double cell_size) {
  return static_cast<int>(std::clamp(std::floor(value / cell_size), -kMaxCell, kMaxCell));
}

// In the map's dimension as in space a box has an extent: the tree chooses by volume, and that of a box
// without extent is always nothing.
int64_t MapMin(MapId map) { return static_cast<int64_t>(2 * map.value()); }
int64_t MapMax(MapId map) { return MapMin(map) + 1; }

}  // namespace

const SpatialIndex& PointIndex() { return kPointIndex; }
const SpatialIndex& KeyFrameIndex() { return kKeyFrameIndex; }

Cell CellOf(const SpatialIndex& index, const Eigen::Vector3d& position) {
  return position
      .unaryExpr([&](double value) { return static_cast<double>(CellCoordinate(value, index.cell_size)); })
      .cast<int>();
}

absl::Status PutCell(Connection& connection, const SpatialIndex& index, MapId map, uint64_t id,
                     const Cell& cell) {
  Query query(connection, index.replace);
  query.Bind(KeyOf(map, id)).Bind(MapMin(map)).Bind(MapMax(map));
  for (int axis = 0; axis < 3; ++axis) query.Bind(cell[axis]).Bind(cell[axis] + 1);
  return query.Run();
}

absl::Status EraseCell(Connection& connection, const SpatialIndex& index, MapId map, uint64_t id) {
  return RunQuery(connection, index.erase, KeyOf(map, id));
}

absl::StatusOr<std::optional<Cell>> GetCell(Connection& connection, const SpatialIndex& index, MapId map,
                                            uint64_t id) {
  Query query(connection, index.get);
  query.Bind(KeyOf(map, id));
  SEMMAP_ASSIGN_OR_RETURN(const bool found, query.Step());
  if (!found) return std::nullopt;
  return Cell(static_cast<int>(query.Int(0)), static_cast<int>(query.Int(1)), static_cast<int>(query.Int(2)));
}

absl::StatusOr<std::optional<std::vector<uint64_t>>> FindCandidates(Connection& connection,
                                                                    const SpatialIndex& index, MapId map,
                                                                    const Eigen::AlignedBox3d& box,
                                                                    size_t limit) {
  const Cell first = CellOf(index, box.min());
  const Cell last = CellOf(index, box.max());
  Query query(connection, index.find);
  query.Bind(MapMin(map)).Bind(MapMax(map));
  for (int axis = 0; axis < 3; ++axis) query.Bind(first[axis]).Bind(last[axis]);
  query.Bind(limit + 1);
  std::vector<uint64_t> ids;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, query.Step());
    if (!row) break;
    ids.push_back(query.Unsigned(0) % kIdLimit);
  }
  if (ids.size() > limit) return std::nullopt;
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace semmap::storage::sqlite
