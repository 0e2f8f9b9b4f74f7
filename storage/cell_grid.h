#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "slam/map/map_delta.h"

// The grid by which a backend finds things in space: things are indexed by the cube they are in, so that what
// moves a little, as everything near a vehicle does with each bundle adjustment, mostly stays where it was in
// the index.
namespace semmap::storage {

using Cell = Eigen::Vector3i;

// A coordinate of a cell lies in (-kCellLimit, kCellLimit), so that three fit one 64-bit key.
constexpr int kCellLimit = 1 << 20;

// The cube with edges of `cell_size` that holds the position; beyond the grid, its outermost cube on that
// side.
Cell CellOf(const Eigen::Vector3d& position, double cell_size);

// Not negative, different for different cells.
int64_t PackCell(const Cell& cell);
Cell UnpackCell(int64_t key);

// A power of two that suits a map: some tens of points in a cube, told by the distances from which its first
// points were seen, because the unit of a monocular map is arbitrary.
double ChooseCellSize(const std::vector<MapPointRecord>& points);
// Whether ChooseCellSize can have answered this.
bool IsCellSize(double size);

}  // namespace semmap::storage
