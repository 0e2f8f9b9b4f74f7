#include "tests/bench/experiment/experiment_report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/table.h"

namespace semmap::bench {
namespace {

constexpr const char* kBase = "base";

std::vector<const VariantResult*> Select(const std::vector<VariantResult>& results, const std::string& route,
                                         const std::string& variant) {
  std::vector<const VariantResult*> selected;
  for (const VariantResult& result : results) {
    if (result.route == route && result.variant == variant) selected.push_back(&result);
  }
  return selected;
}

// Both algorithms' percentages of the pairs of seeds where both have one.
void CompareWithBase(const std::vector<const VariantResult*>& base,
                     const std::vector<const VariantResult*>& own, RouteFigures* figures) {
  std::vector<double> before;
  std::vector<double> after;
  std::vector<double> changes;
  for (const VariantResult* result : own) {
    const auto partner = std::find_if(base.begin(), base.end(), [&](const VariantResult* other) {
      return other->traffic_seed == result->traffic_seed && other->run == result->run;
    });
    if (partner == base.end() || !(*partner)->mape_percent || !result->mape_percent) continue;
    before.push_back(*(*partner)->mape_percent);
    after.push_back(*result->mape_percent);
    changes.push_back(100 * (after.back() / before.back() - 1));
  }
  if (changes.empty()) return;
  figures->change_percent = 100 * (SpreadOf(after).mean / SpreadOf(before).mean - 1);
  figures->change_of_seeds_percent = SpreadOf(changes);
}

RouteFigures FiguresOf(const std::vector<VariantResult>& results, const std::string& route,
                       const std::string& variant) {
  RouteFigures figures;
  figures.route = route;
  figures.variant = variant;
  std::vector<double> duration, length, mape, ate, tracked;
  const auto own = Select(results, route, variant);
  for (const VariantResult* result : own) {
    duration.push_back(result->duration_s);
    length.push_back(result->length_m);
    if (result->mape_percent) mape.push_back(*result->mape_percent);
    if (result->ate_m) ate.push_back(*result->ate_m);
    tracked.push_back(static_cast<double>(result->tracked) / std::max(1, result->frames));
  }
  figures.duration_s = SpreadOf(duration);
  figures.length_m = SpreadOf(length);
  figures.mape_percent = SpreadOf(mape);
  figures.ate_m = SpreadOf(ate);
  figures.tracked_share = SpreadOf(tracked);
  if (variant != kBase) CompareWithBase(Select(results, route, kBase), own, &figures);
  return figures;
}

void Add(const MapCensus::Group& from, MapCensus::Group* to) {
  to->points += from.points;
  to->on_traffic_vehicles += from.on_traffic_vehicles;
  to->on_pedestrians += from.on_pedestrians;
  to->on_parked_vehicles += from.on_parked_vehicles;
  to->on_sky += from.on_sky;
}

std::string Percent(uint64_t part, uint64_t whole) {
  return whole == 0
             ? "-"
             : absl::StrFormat("%.2f %%", 100.0 * static_cast<double>(part) / static_cast<double>(whole));
}

std::string WithSpread(const Spread& spread, const char* format) {
  if (spread.count == 0) return "-";
  const auto print = [&](double value) {
    return absl::StrFormat(*absl::ParsedFormat<'f'>::New(format), value);
  };
  return absl::StrCat(print(spread.mean), " +- ", print(spread.deviation));
}

std::string AccuracyTable(const std::vector<VariantResult>& results, const std::string& variant) {
  client::Table table({"class", "active points", "right by votes", "right labels"});
  const MapCensus census = TotalCensus(results, variant);
  MapCensus::ClassTally sum;
  for (size_t id = 0; id < census.classes.size(); ++id) {
    const MapCensus::ClassTally& tally = census.classes[id];
    if (tally.points == 0) continue;
    table.AddRow({std::string(kSemanticClasses[id].name), absl::StrCat(tally.points),
                  Percent(tally.correct, tally.points), Percent(tally.correct_labels, tally.labels)});
    sum.points += tally.points;
    sum.correct += tally.correct;
    sum.labels += tally.labels;
    sum.correct_labels += tally.correct_labels;
  }
  table.AddRow({"all", absl::StrCat(sum.points), Percent(sum.correct, sum.points),
                Percent(sum.correct_labels, sum.labels)});
  return table.Format();
}

std::string CensusTable(const std::vector<VariantResult>& results, const std::vector<std::string>& variants) {
  client::Table table({"variant", "points", "active", "on moving vehicles", "on pedestrians",
                       "on parked vehicles", "on the sky", "keypoints on traffic"});
  for (const std::string& variant : variants) {
    const MapCensus census = TotalCensus(results, variant);
    if (census.all.points == 0) continue;
    const MapCensus::Group& active = census.active;
    table.AddRow({variant, absl::StrCat(census.all.points), absl::StrCat(active.points),
                  Percent(active.on_traffic_vehicles, active.points),
                  Percent(active.on_pedestrians, active.points),
                  Percent(active.on_parked_vehicles, active.points), Percent(active.on_sky, active.points),
                  Percent(census.keypoints_on_traffic, census.keypoints)});
  }
  return table.Format();
}

}  // namespace

Spread SpreadOf(const std::vector<double>& values) {
  Spread spread;
  spread.count = values.size();
  if (values.empty()) return spread;
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  double squares = 0;
  for (const double value : values) squares += (value - spread.mean) * (value - spread.mean);
  if (values.size() > 1) spread.deviation = std::sqrt(squares / static_cast<double>(values.size() - 1));
  spread.least = *std::min_element(values.begin(), values.end());
  spread.greatest = *std::max_element(values.begin(), values.end());
  return spread;
}

std::vector<RouteFigures> Summarize(const std::vector<VariantResult>& results,
                                    const std::vector<std::string>& variants) {
  std::set<std::string> routes;
  for (const VariantResult& result : results) routes.insert(result.route);
  std::vector<RouteFigures> figures;
  for (const std::string& route : routes) {
    for (const std::string& variant : variants) {
      RouteFigures row = FiguresOf(results, route, variant);
      if (row.duration_s.count > 0) figures.push_back(std::move(row));
    }
  }
  return figures;
}

std::optional<double> MeanChange(const std::vector<RouteFigures>& figures, const std::string& variant) {
  double sum = 0;
  int routes = 0;
  for (const RouteFigures& row : figures) {
    if (row.variant != variant) continue;
    if (!row.change_percent) return std::nullopt;
    sum += *row.change_percent;
    ++routes;
  }
  return routes == 0 ? std::nullopt : std::optional<double>(sum / routes);
}

MapCensus TotalCensus(const std::vector<VariantResult>& results, const std::string& variant) {
  MapCensus total;
  for (const VariantResult& result : results) {
    if (result.variant != variant) continue;
    Add(result.census.all, &total.all);
    Add(result.census.active, &total.active);
    total.keypoints += result.census.keypoints;
    total.keypoints_on_traffic += result.census.keypoints_on_traffic;
    for (size_t id = 0; id < total.classes.size(); ++id) {
      total.classes[id].points += result.census.classes[id].points;
      total.classes[id].correct += result.census.classes[id].correct;
      total.classes[id].labels += result.census.classes[id].labels;
      total.classes[id].correct_labels += result.census.classes[id].correct_labels;
    }
  }
  return total;
}

std::string ReportText(const std::vector<VariantResult>& results, const std::vector<std::string>& variants) {
  client::Table table({"route", "variant", "runs", "duration s", "length m", "MAPE %", "change",
                       "change by seed", "ATE m", "tracked"});
  const std::vector<RouteFigures> figures = Summarize(results, variants);
  for (const RouteFigures& row : figures) {
    table.AddRow({row.route, row.variant, absl::StrCat(row.duration_s.count),
                  absl::StrFormat("%.1f", row.duration_s.mean), absl::StrFormat("%.1f", row.length_m.mean),
                  WithSpread(row.mape_percent, "%.2f"),
                  row.change_percent ? absl::StrFormat("%+.1f %%", *row.change_percent) : "-",
                  WithSpread(row.change_of_seeds_percent, "%+.1f"), WithSpread(row.ate_m, "%.2f"),
                  WithSpread(row.tracked_share, "%.3f")});
  }
  std::string text = table.Format() + "\n";
  for (const std::string& variant : variants) {
    if (const auto change = MeanChange(figures, variant))
      absl::StrAppendFormat(&text, "mean relative change of %s over the routes: %+.1f %%\n", variant,
                            *change);
  }
  absl::StrAppend(&text, "\nWhat active points are on, by the town's truth\n",
                  CensusTable(results, variants));
  for (const std::string& variant : variants) {
    if (variant == kBase || TotalCensus(results, variant).all.points == 0) continue;
    absl::StrAppend(&text, "\nClasses of active points, ", variant, "\n", AccuracyTable(results, variant));
  }
  return text;
}

nlohmann::json ReportJson(const std::vector<VariantResult>& results,
                          const std::vector<std::string>& variants) {
  const auto spread = [](const Spread& s) {
    return nlohmann::json{{"count", s.count},
                          {"mean", s.mean},
                          {"deviation", s.deviation},
                          {"least", s.least},
                          {"greatest", s.greatest}};
  };
  const std::vector<RouteFigures> figures = Summarize(results, variants);
  nlohmann::json json = {{"rows", nlohmann::json::array()},
                         {"mean_change_percent", nlohmann::json::object()}};
  for (const RouteFigures& row : figures) {
    json["rows"].push_back({{"route", row.route},
                            {"variant", row.variant},
                            {"duration_s", spread(row.duration_s)},
                            {"length_m", spread(row.length_m)},
                            {"mape_percent", spread(row.mape_percent)},
                            {"ate_m", spread(row.ate_m)},
                            {"tracked_share", spread(row.tracked_share)},
                            {"change_of_seeds_percent", spread(row.change_of_seeds_percent)}});
    if (row.change_percent) json["rows"].back()["change_percent"] = *row.change_percent;
  }
  for (const std::string& variant : variants) {
    if (const auto change = MeanChange(figures, variant)) json["mean_change_percent"][variant] = *change;
  }
  return json;
}

}  // namespace semmap::bench
