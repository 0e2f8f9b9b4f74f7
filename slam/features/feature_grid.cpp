#include "slam/features/feature_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace semmap {
namespace {

// About two keypoints per cell at 2000 keypoints on a VGA to KITTI sized image.
constexpr float kCellPixels = 20.0F;
// Undistorted bounds of a wide lens can be huge; the grid then gets coarser instead of larger.
constexpr float kMaxCellsPerSide = 256.0F;
constexpr int kNoCell = -1;

// Clamping is monotone, so a keypoint outside the bounds is found through the border cells.
int ClampedCell(float offset, float inverse_cell, int count) {
  return static_cast<int>(std::clamp(offset * inverse_cell, 0.0F, static_cast<float>(count - 1)));
}

int CellsAlong(float extent, float inverse_cell) {
  return std::max(1, static_cast<int>(std::ceil(extent * inverse_cell)));
}

}  // namespace

void FeatureGrid::Assign(const ImageBounds& bounds, const std::vector<Keypoint>& keypoints) {
  bounds_ = bounds;
  const float width = std::max(0.0F, bounds.max_x - bounds.min_x);
  const float height = std::max(0.0F, bounds.max_y - bounds.min_y);
  inverse_cell_ = 1.0F / std::max({kCellPixels, width / kMaxCellsPerSide, height / kMaxCellsPerSide});
  columns_ = CellsAlong(width, inverse_cell_);
  rows_ = CellsAlong(height, inverse_cell_);

  const auto cell_of = [&](const Keypoint& keypoint) {
    if (!std::isfinite(keypoint.x) || !std::isfinite(keypoint.y)) return kNoCell;
    return ClampedCell(keypoint.y - bounds.min_y, inverse_cell_, rows_) * columns_ +
           ClampedCell(keypoint.x - bounds.min_x, inverse_cell_, columns_);
  };
  // A counting sort that keeps the order of keypoints within a cell. Indices are 16 bits wide.
  const size_t count = std::min<size_t>(keypoints.size(), std::numeric_limits<uint16_t>::max() + size_t{1});
  cell_begin_.assign(static_cast<size_t>(rows_) * columns_ + 1, 0);
  for (size_t i = 0; i < count; ++i) {
    if (const int cell = cell_of(keypoints[i]); cell != kNoCell) ++cell_begin_[cell];
  }
  int end = 0;
  for (int& begin : cell_begin_) begin = (end += begin);
  indices_.resize(end);
  for (size_t i = count; i-- > 0;) {
    if (const int cell = cell_of(keypoints[i]); cell != kNoCell) {
      indices_[--cell_begin_[cell]] = static_cast<uint16_t>(i);
    }
  }
}

bool FeatureGrid::CellRange(float x, float y, float radius, int* min_column, int* max_column, int* min_row,
                            int* max_row) const {
  if (cell_begin_.empty() || !std::isfinite(x) || !std::isfinite(y) || !(radius >= 0)) return false;
  *min_column = ClampedCell(x - radius - bounds_.min_x, inverse_cell_, columns_);
  *max_column = ClampedCell(x + radius - bounds_.min_x, inverse_cell_, columns_);
  *min_row = ClampedCell(y - radius - bounds_.min_y, inverse_cell_, rows_);
  *max_row = ClampedCell(y + radius - bounds_.min_y, inverse_cell_, rows_);
  return true;
}

}  // namespace semmap
