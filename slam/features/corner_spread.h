#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "slam/features/corner.h"

namespace semmap {

// Which of many corners to keep so that they are spread evenly and strong: the image is cut into as many
// square cells as corners are wanted; every cell gives its best corner, then every cell its second best, and
// so on until the number is reached, the last round by score. Corners not above `strong_score` count only in
// cells without a stronger one. Keeps its buffers between calls. Not thread-safe. Deterministic.
class CornerSpread {
 public:
  // Region that holds the corners: x in [min_x, max_x), y in [min_y, max_y).
  struct Region {
    int min_x = 0;
    int min_y = 0;
    int max_x = 0;
    int max_y = 0;
  };

  // Fills `selected` with at most `wanted` of `corners`.
  void Select(std::span<const Corner> corners, const Region& region, int wanted, int strong_score,
              std::vector<Corner>* selected);

 private:
  // Corners of a cell that are still to be had.
  struct Cell {
    uint32_t next = 0;
    uint32_t end = 0;
    int above_score = 0;
  };

  void SortIntoCells(std::span<const Corner> corners, const Region& region, int wanted);
  void TakeRound(int strong_score);

  std::vector<uint32_t> column_of_x_;
  std::vector<uint32_t> first_of_y_;  // first cell of the cell row that pixel row y lies in
  std::vector<uint32_t> cell_begin_;
  std::vector<Corner> by_cell_;
  std::vector<Cell> cells_;  // that have corners left
  std::vector<Corner> round_;
};

}  // namespace semmap
