#pragma once

#include <cstddef>
#include <span>

namespace semmap {

// What one says about a list of errors. std is of the population (divided by n), as evaluation tools have it;
// the median of an even count is the mean of the middle two.
struct ErrorStatistics {
  size_t count = 0;
  double rmse = 0;
  double mean = 0;
  double median = 0;
  double std = 0;
  double min = 0;
  double max = 0;
};

// All zero for an empty list.
ErrorStatistics Summarize(std::span<const double> errors);

// The value below which `fraction` (in [0, 1]) of the values lie, interpolated between neighbours; 0 for no
// values.
double Percentile(std::span<const double> values, double fraction);

}  // namespace semmap
