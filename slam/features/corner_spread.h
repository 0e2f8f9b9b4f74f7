#pragma once

#include <cstdint>
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
  void Select(const std::vector<Corner>& corners, const Region& region, int wanted, int strong_score,
              std::vector<Corner>* selected);

 private:
  void SortIntoCells(const std::vector<Corner>& corners, const Region& region, int wanted);
  int RankCell(int begin, int end, int strong_score);

  std::vector<uint32_t> cell_begin_;
  std::vector<uint32_t> cell_count_;
  std::vector<Corner> by_cell_;
  std::vector<Corner> last_round_;
};

}  // namespace semmap
