#include "slam/features/corner_spread.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace semmap {
namespace {

bool Stronger(const Corner& a, const Corner& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

}  // namespace

void CornerSpread::SortIntoCells(const std::vector<Corner>& corners, const Region& region, int wanted) {
  const float width = static_cast<float>(region.max_x - region.min_x);
  const float height = static_cast<float>(region.max_y - region.min_y);
  const float inverse_side = std::sqrt(static_cast<float>(wanted) / (width * height));
  const int columns = std::max(1, static_cast<int>(width * inverse_side));
  const int rows = std::max(1, static_cast<int>(height * inverse_side));
  const float columns_per_pixel = static_cast<float>(columns) / width;
  const float rows_per_pixel = static_cast<float>(rows) / height;
  const auto cell_of = [&](const Corner& corner) {
    const int column = static_cast<int>(static_cast<float>(corner.x - region.min_x) * columns_per_pixel);
    const int row = static_cast<int>(static_cast<float>(corner.y - region.min_y) * rows_per_pixel);
    return std::min(row, rows - 1) * columns + std::min(column, columns - 1);
  };

  cell_begin_.assign(static_cast<size_t>(columns) * rows + 1, 0);
  for (const Corner& corner : corners) ++cell_begin_[cell_of(corner)];
  uint32_t end = 0;
  for (uint32_t& begin : cell_begin_) begin = (end += begin);
  by_cell_.resize(corners.size());
  for (const Corner& corner : corners) by_cell_[--cell_begin_[cell_of(corner)]] = corner;
}

// Sorts a cell by strength; returns how many of its corners count.
int CornerSpread::RankCell(int begin, int end, int strong_score) {
  if (begin == end) return 0;
  std::sort(by_cell_.begin() + begin, by_cell_.begin() + end, Stronger);
  if (by_cell_[begin].score <= strong_score) return end - begin;
  int count = 1;
  while (begin + count < end && by_cell_[begin + count].score > strong_score) ++count;
  return count;
}

void CornerSpread::Select(const std::vector<Corner>& corners, const Region& region, int wanted,
                          int strong_score, std::vector<Corner>* selected) {
  selected->clear();
  if (wanted <= 0 || corners.empty()) return;
  SortIntoCells(corners, region, wanted);
  const size_t cells = cell_begin_.size() - 1;
  cell_count_.resize(cells);
  for (size_t cell = 0; cell < cells; ++cell) {
    cell_count_[cell] =
        RankCell(static_cast<int>(cell_begin_[cell]), static_cast<int>(cell_begin_[cell + 1]), strong_score);
  }
  for (uint32_t rank = 0;; ++rank) {
    last_round_.clear();
    for (size_t cell = 0; cell < cells; ++cell) {
      if (rank < cell_count_[cell]) last_round_.push_back(by_cell_[cell_begin_[cell] + rank]);
    }
    const size_t room = static_cast<size_t>(wanted) - selected->size();
    if (last_round_.size() > room) {
      std::nth_element(last_round_.begin(), last_round_.begin() + static_cast<ptrdiff_t>(room),
                       last_round_.end(), Stronger);
      last_round_.resize(room);
    }
    if (last_round_.empty()) return;
    selected->insert(selected->end(), last_round_.begin(), last_round_.end());
  }
}

}  // namespace semmap
