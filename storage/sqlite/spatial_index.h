#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

// The R*Trees over map points and keyframes. They hold the grid cell that a thing is in, not its position: a
// query looks up the cells that meet its box and then checks the exact positions in the rows, and a thing
// that moves within its cell costs the tree nothing.
namespace semmap::storage::sqlite {

struct SpatialIndex {
  // Edge of a cell in units of the map; a power of two, part of the schema.
  double cell_size;
  // Statements on the tree.
  const char* replace;
  const char* erase;
  const char* find;
  const char* get;
};
const SpatialIndex& PointIndex();
const SpatialIndex& KeyFrameIndex();

// Integer coordinates of a cell; positions beyond what fits fall into the outermost cells.
using Cell = Eigen::Vector3i;
Cell CellOf(const SpatialIndex& index, const Eigen::Vector3d& position);

// `id` is that of a map point or keyframe, below kIdLimit.
absl::Status PutCell(Connection& connection, const SpatialIndex& index, MapId map, uint64_t id,
                     const Cell& cell);
absl::Status EraseCell(Connection& connection, const SpatialIndex& index, MapId map, uint64_t id);
// nullopt when the thing is not in the tree.
absl::StatusOr<std::optional<Cell>> GetCell(Connection& connection, const SpatialIndex& index, MapId map,
                                            uint64_t id);

// Ids of all that may be inside the box, ascending; a superset by less than a cell on each side. nullopt when
// there are more than `limit`: then a scan of the rows is no slower.
absl::StatusOr<std::optional<std::vector<uint64_t>>> FindCandidates(Connection& connection,
                                                                    const SpatialIndex& index, MapId map,
                                                                    const Eigen::AlignedBox3d& box,
                                                                    size_t limit);

}  // namespace semmap::storage::sqlite
