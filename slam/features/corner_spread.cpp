#include "slam/features/corner_spread.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace semmap {
namespace {

// With one the spread is the most even, but many a corner is so weak that other frames do not show it; with
// more there are more matches on fewer parts of the image. Four gives a tenth more matches for a tenth fewer
// parts.
constexpr double kCornersPerCell = 4;

bool Stronger(const Corner& a, const Corner& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

bool Weaker(const Corner& a, const Corner& b) { return a.score < b.score; }

}  // namespace

void CornerSpread::SortIntoCells(std::span<const Corner> corners, const Region& region, int wanted) {
  const int width = region.max_x - region.min_x;
  const int height = region.max_y - region.min_y;
  const double side = std::sqrt(kCornersPerCell * width * height / wanted);
  const int columns = std::max(1, static_cast<int>(width / side));
  const int rows = std::max(1, static_cast<int>(height / side));
  column_of_x_.resize(width);
  for (int x = 0; x < width; ++x) column_of_x_[x] = static_cast<uint32_t>(x * columns / width);
  first_of_y_.resize(height);
  for (int y = 0; y < height; ++y) first_of_y_[y] = static_cast<uint32_t>(y * rows / height * columns);
  const auto cell_of = [&](const Corner& corner) {
    return first_of_y_[corner.y - region.min_y] + column_of_x_[corner.x - region.min_x];
  };

  cell_begin_.assign(static_cast<size_t>(columns) * rows + 1, 0);
  for (const Corner& corner : corners) ++cell_begin_[cell_of(corner)];
  uint32_t end = 0;
  for (uint32_t& begin : cell_begin_) begin = (end += begin);
  by_cell_.resize(corners.size());
  for (const Corner& corner : corners) by_cell_[--cell_begin_[cell_of(corner)]] = corner;
  cells_.clear();
  for (size_t cell = 0; cell + 1 < cell_begin_.size(); ++cell) {
    if (cell_begin_[cell] < cell_begin_[cell + 1])
      cells_.push_back({cell_begin_[cell], cell_begin_[cell + 1], 0});
  }
}

// Moves the best corner that is left in each cell to round_, and forgets cells that have no more.
void CornerSpread::TakeRound(int strong_score) {
  round_.clear();
  size_t kept = 0;
  for (Cell cell : cells_) {
    const auto next = by_cell_.begin() + cell.next;
    std::iter_swap(next, std::max_element(next, by_cell_.begin() + cell.end, Weaker));
    if (next->score <= cell.above_score) continue;
    round_.push_back(*next);
    if (next->score > strong_score) cell.above_score = strong_score;
    if (++cell.next < cell.end) cells_[kept++] = cell;
  }
  cells_.resize(kept);
}

void CornerSpread::Select(std::span<const Corner> corners, const Region& region, int wanted, int strong_score,
                          std::vector<Corner>* selected) {
  selected->clear();
  if (wanted <= 0 || corners.empty()) return;
  SortIntoCells(corners, region, wanted);
  while (selected->size() < static_cast<size_t>(wanted)) {
    TakeRound(strong_score);
    if (round_.empty()) return;
    const size_t room = static_cast<size_t>(wanted) - selected->size();
    if (round_.size() > room) {
      std::nth_element(round_.begin(), round_.begin() + static_cast<ptrdiff_t>(room), round_.end(), Stronger);
      round_.resize(room);
    }
    selected->insert(selected->end(), round_.begin(), round_.end());
  }
}

}  // namespace semmap
