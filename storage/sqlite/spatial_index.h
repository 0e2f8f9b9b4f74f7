#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/cell_grid.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

// The two R*Trees. Both hold cells of the grid instead of positions, so that a query gets a few too many and
// checks the exact positions in the rows, and what moves within its cell costs a tree nothing. Measured
// against an entry for each point: a third of the time to store a step, and a quarter of the size.
namespace semmap::storage::sqlite {

// --- Keyframes: one entry each, in cells of kKeyFrameCell.
constexpr double kKeyFrameCell = 0.25;

absl::Status PutKeyFrameCell(Connection& connection, MapId map, KeyFrameId keyframe, const Cell& cell);
absl::Status EraseKeyFrameCell(Connection& connection, MapId map, KeyFrameId keyframe);
// nullopt when the keyframe is not in the tree.
absl::StatusOr<std::optional<Cell>> GetKeyFrameCell(Connection& connection, MapId map, KeyFrameId keyframe);
// Ids of all keyframes that may be inside the box, ascending; nullopt when there are more than `limit`: then
// to scan the rows is no slower.
absl::StatusOr<std::optional<std::vector<uint64_t>>> FindKeyFrames(Connection& connection, MapId map,
                                                                   const Eigen::AlignedBox3d& box,
                                                                   size_t limit);

// --- Map points: one entry for each cell that has or had a point; rows carry the key of their cell. A cell
// stays when its last point leaves, which costs a query one look.

absl::Status AddPointCell(Connection& connection, MapId map, const Cell& cell);
// Keys of the cells that meet the box; nullopt when there are more than `limit`.
absl::StatusOr<std::optional<std::vector<int64_t>>> FindPointCells(Connection& connection, MapId map,
                                                                   const Eigen::AlignedBox3d& box,
                                                                   double cell_size, size_t limit);
absl::StatusOr<std::vector<int64_t>> AllPointCells(Connection& connection, MapId map);
// Removes at most `limit` cells of a map; true when none were left.
absl::StatusOr<bool> ErasePointCells(Connection& connection, MapId map, int limit);

}  // namespace semmap::storage::sqlite
