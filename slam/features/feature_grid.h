#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "slam/features/frame_features.h"
#include "slam/geometry/camera.h"

namespace semmap {

// Buckets keypoints by image cell so that a guided search looks at a few of them. Compressed rows: indices of
// one cell lie together, cells of one grid row follow each other. A value; safe to read from several threads.
class FeatureGrid {
 public:
  FeatureGrid() = default;
  FeatureGrid(const ImageBounds& bounds, const std::vector<Keypoint>& keypoints) {
    Assign(bounds, keypoints);
  }
  // Rebuilds in place, reusing memory.
  void Assign(const ImageBounds& bounds, const std::vector<Keypoint>& keypoints);

  // Calls visit(index) for every keypoint with |dx| <= radius and |dy| <= radius (square window), in a fixed
  // order.
  template <typename Visitor>
  void ForEachInWindow(const std::vector<Keypoint>& keypoints, float x, float y, float radius,
                       Visitor&& visit) const {
    int min_column, max_column, min_row, max_row;
    if (!CellRange(x, y, radius, &min_column, &max_column, &min_row, &max_row)) return;
    for (int row = min_row; row <= max_row; ++row) {
      const int* first = cell_begin_.data() + row * columns_ + min_column;
      const int begin = first[0];
      const int end = first[max_column - min_column + 1];
      for (int i = begin; i < end; ++i) {
        const Keypoint& keypoint = keypoints[indices_[i]];
        if (keypoint.x - x > radius || x - keypoint.x > radius || keypoint.y - y > radius ||
            y - keypoint.y > radius) {
          continue;
        }
        visit(static_cast<int>(indices_[i]));
      }
    }
  }

  const ImageBounds& bounds() const { return bounds_; }

 private:
  bool CellRange(float x, float y, float radius, int* min_column, int* max_column, int* min_row,
                 int* max_row) const;

  ImageBounds bounds_;
  float inverse_cell_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<int> cell_begin_;  // rows * columns + 1 entries into indices_
  std::vector<uint16_t> indices_;
};

}  // namespace semmap
