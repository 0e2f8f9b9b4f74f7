#include "slam/evaluation/statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace semmap {

double Percentile(std::span<const double> values, double fraction) {
  if (values.empty()) return 0;
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double position = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  const double weight = position - static_cast<double>(below);
  return (1.0 - weight) * sorted[below] + weight * sorted[above];
}

ErrorStatistics Summarize(std::span<const double> errors) {
  ErrorStatistics statistics;
  if (errors.empty()) return statistics;
  const double count = static_cast<double>(errors.size());
  double sum = 0;
  double sum_of_squares = 0;
  for (const double error : errors) {
    sum += error;
    sum_of_squares += error * error;
  }
  statistics.count = errors.size();
  statistics.mean = sum / count;
  statistics.rmse = std::sqrt(sum_of_squares / count);
  double deviations = 0;
  for (const double error : errors) deviations += (error - statistics.mean) * (error - statistics.mean);
  statistics.std = std::sqrt(deviations / count);
  statistics.median = Percentile(errors, 0.5);
  statistics.min = *std::min_element(errors.begin(), errors.end());
  statistics.max = *std::max_element(errors.begin(), errors.end());
  return statistics;
}

}  // namespace semmap
