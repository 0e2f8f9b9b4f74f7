#include "storage/cell_grid.h"

#include <algorithm>
#include <cmath>

namespace semmap::storage {
namespace {

constexpr int kBits = 21;
constexpr int64_t kMask = (int64_t{1} << kBits) - 1;

// In metres on a road: points are seen from some 30 m at most, and 8 m cubes hold some tens of them.
constexpr double kDefaultSize = 8.0;
constexpr double kCellsToTheHorizon = 4.0;
constexpr double kMinExponent = -10;
constexpr double kMaxExponent = 10;

}  // namespace

Cell CellOf(const Eigen::Vector3d& position, double cell_size) {
  constexpr double kLast = kCellLimit - 1;
  const Eigen::Array3d cell = (position.array() / cell_size).floor();
  return cell.max(-kLast).min(kLast).cast<int>();
}

int64_t PackCell(const Cell& cell) {
  const auto part = [](int coordinate) { return static_cast<int64_t>(coordinate) + kCellLimit; };
  return part(cell.x()) << (2 * kBits) | part(cell.y()) << kBits | part(cell.z());
}

Cell UnpackCell(int64_t key) {
  const auto part = [key](int shift) { return static_cast<int>((key >> shift & kMask) - kCellLimit); };
  return {part(2 * kBits), part(kBits), part(0)};
}

double ChooseCellSize(const std::vector<MapPointRecord>& points) {
  std::vector<float> distances;
  for (const MapPointRecord& point : points) {
    if (point.max_distance > 0) distances.push_back(point.max_distance);
  }
  if (distances.empty()) return kDefaultSize;
  const auto median = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), median, distances.end());
  const double exponent = std::round(std::log2(static_cast<double>(*median) / kCellsToTheHorizon));
  return std::exp2(std::clamp(exponent, kMinExponent, kMaxExponent));
}

bool IsCellSize(double size) {
  int exponent = 0;
  return size >= std::exp2(kMinExponent) && size <= std::exp2(kMaxExponent) &&
         std::frexp(size, &exponent) == 0.5;
}

}  // namespace semmap::storage
