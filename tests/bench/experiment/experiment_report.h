#pragma once

#include <string>
#include <vector>

#include "nlohmann/json.hpp"
#include "tests/bench/experiment/variant_result.h"

namespace semmap::bench {

// Mean, standard deviation (of the sample), least and greatest of some values.
struct Spread {
  size_t count = 0;
  double mean = 0;
  double deviation = 0;
  double least = 0;
  double greatest = 0;
};
Spread SpreadOf(const std::vector<double>& values);

// What one variant did on one route, over the seeds.
struct RouteFigures {
  std::string route;
  std::string variant;
  Spread duration_s;
  Spread length_m;
  Spread mape_percent;  // of the runs that have one
  Spread ate_m;
  Spread tracked_share;
  // Of the mean MAPE against the base algorithm's, percent; and the change of each seed for itself. Only
  // seeds that both have.
  std::optional<double> change_percent;
  Spread change_of_seeds_percent;
};

// One row for each route and variant, in the order of `variants`; routes sorted.
std::vector<RouteFigures> Summarize(const std::vector<VariantResult>& results,
                                    const std::vector<std::string>& variants);

// The paper's closing figure: the mean of the relative changes of the routes. Nothing where a route has none.
std::optional<double> MeanChange(const std::vector<RouteFigures>& figures, const std::string& variant);

// Sums over all drives of a variant.
MapCensus TotalCensus(const std::vector<VariantResult>& results, const std::string& variant);

// The paper's Table 2 with what stands beside it; then what the points are on; then class by class how right
// the active points and the single labels are.
std::string ReportText(const std::vector<VariantResult>& results, const std::vector<std::string>& variants);
nlohmann::json ReportJson(const std::vector<VariantResult>& results,
                          const std::vector<std::string>& variants);

}  // namespace semmap::bench
