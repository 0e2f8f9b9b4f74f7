#include "tests/bench/slam_bench_report.h"

#include <algorithm>
#include <array>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "slam/evaluation/statistics.h"

namespace semmap::bench {
namespace {

double Median(const std::vector<double>& values) { return Percentile(values, 0.5); }
double Percentile95(const std::vector<double>& values) { return Percentile(values, 0.95); }

struct Stage {
  const char* name;
  std::vector<double> StageSamples::*samples;
};

constexpr std::array<Stage, 10> kStages = {{
    {"decode", &StageSamples::decode},
    {"extract", &StageSamples::extract},
    {"stereo", &StageSamples::stereo},
    {"classify", &StageSamples::classify},
    {"match", &StageSamples::match},
    {"optimize", &StageSamples::optimize},
    {"track", &StageSamples::track},
    {"map", &StageSamples::map},
    {"unit", &StageSamples::unit},
    {"unit cpu", &StageSamples::unit_cpu},
}};

nlohmann::json StagesJson(const StageSamples& stages) {
  nlohmann::json json;
  for (const Stage& stage : kStages) {
    const std::vector<double>& samples = stages.*stage.samples;
    json[stage.name] = {
        {"median_ms", Median(samples)}, {"p95_ms", Percentile95(samples)}, {"count", samples.size()}};
  }
  return json;
}

// The samples of all runs together.
StageSamples Pool(const std::vector<RunResult>& runs) {
  StageSamples all;
  for (const RunResult& run : runs) {
    for (const Stage& stage : kStages) {
      const std::vector<double>& samples = run.stages.*stage.samples;
      (all.*stage.samples).insert((all.*stage.samples).end(), samples.begin(), samples.end());
    }
  }
  return all;
}

double InUnits(double milliseconds, double unit_ms) { return unit_ms > 0 ? milliseconds / unit_ms : 0.0; }

nlohmann::json RunJson(const RunResult& run) {
  const double unit_ms = Median(run.stages.unit);
  const double unit_cpu_ms = Median(run.stages.unit_cpu);
  const double frames = static_cast<double>(std::max<uint64_t>(run.frames, 1));
  nlohmann::json json = {
      {"frames", run.frames},
      {"tracked", run.tracked},
      {"ate_rmse_m", run.ate_rmse_m ? nlohmann::json(*run.ate_rmse_m) : nlohmann::json(nullptr)},
      {"median_ms", Median(run.stages.track)},
      {"p95_ms", Percentile95(run.stages.track)},
      {"unit_ms", unit_ms},
      {"unit_cpu_ms", unit_cpu_ms},
      {"median_units", InUnits(Median(run.stages.track), unit_ms)},
      {"cpu_s", run.cpu_s},
      {"cpu_units_per_frame", InUnits(1e3 * run.cpu_s / frames, unit_cpu_ms)},
      {"keyframes", run.keyframes},
      {"points", run.points},
      {"loops", run.loops},
      {"recoveries", run.recoveries},
      {"classified", run.classified},
      {"unclassified", run.unclassified},
      {"peak_rss_mb", run.peak_rss_mb},
      {"wall_s", run.wall_s},
      {"bytes_per_keyframe", run.bytes_per_keyframe},
      {"bytes_per_point", run.bytes_per_point},
  };
  json["stages"] = StagesJson(run.stages);
  return json;
}

// The median over runs of every number of `runs`; values that are no numbers in each of them stay as in the
// first.
nlohmann::json MedianOf(const std::vector<nlohmann::json>& runs) {
  nlohmann::json medians = runs.front();
  for (auto& [key, value] : medians.items()) {
    std::vector<double> values;
    for (const nlohmann::json& run : runs) {
      if (run[key].is_number()) values.push_back(run[key].get<double>());
    }
    if (values.size() != runs.size()) continue;
    if (value.is_number_integer()) {
      value = static_cast<int64_t>(Median(values));
    } else {
      value = Median(values);
    }
  }
  return medians;
}

std::string TotalsOf(const nlohmann::json& figures) {
  const std::string ate = figures["ate_rmse_m"].is_null()
                              ? "no truth"
                              : absl::StrFormat("%.4f m", figures["ate_rmse_m"].get<double>());
  return absl::StrFormat(
      "frames %d, tracked %d, ATE %s, keyframes %d, points %d, loops %d, recoveries %d, with classes %d\n"
      "CPU %.2f s (%.2f units a frame), wall %.2f s, peak RSS %.0f MB, %.0f bytes a keyframe, %.0f a point\n",
      figures["frames"].get<int64_t>(), figures["tracked"].get<int64_t>(), ate,
      figures["keyframes"].get<int64_t>(), figures["points"].get<int64_t>(), figures["loops"].get<int64_t>(),
      figures["recoveries"].get<int64_t>(), figures["classified"].get<int64_t>(),
      figures["cpu_s"].get<double>(), figures["cpu_units_per_frame"].get<double>(),
      figures["wall_s"].get<double>(), figures["peak_rss_mb"].get<double>(),
      figures["bytes_per_keyframe"].get<double>(), figures["bytes_per_point"].get<double>());
}

}  // namespace

nlohmann::json ReportJson(const std::vector<RunResult>& runs) {
  std::vector<nlohmann::json> each;
  for (const RunResult& run : runs) each.push_back(RunJson(run));
  if (each.size() == 1) return each.front();
  nlohmann::json report = MedianOf(each);
  report["stages"] = StagesJson(Pool(runs));
  report["runs"] = each;
  return report;
}

std::string ReportTable(const std::vector<RunResult>& runs) {
  const nlohmann::json report = ReportJson(runs);
  std::string table = absl::StrFormat("%-10s %10s %10s %8s\n", "stage", "median ms", "p95 ms", "units");
  const double unit_ms = report["unit_ms"].get<double>();
  for (const auto& [name, samples] : kStages) {
    const nlohmann::json& stage = report["stages"][name];
    absl::StrAppendFormat(&table, "%-10s %10.2f %10.2f %8.2f\n", name, stage["median_ms"].get<double>(),
                          stage["p95_ms"].get<double>(), InUnits(stage["median_ms"].get<double>(), unit_ms));
  }
  if (runs.size() > 1) {
    for (size_t i = 0; i < runs.size(); ++i)
      absl::StrAppend(&table, "run ", i + 1, ": ", TotalsOf(report["runs"][i]));
    absl::StrAppend(&table, "median of ", runs.size(), ": ");
  }
  return absl::StrCat(table, TotalsOf(report));
}

}  // namespace semmap::bench
