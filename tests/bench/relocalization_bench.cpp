// Blindfolds and kidnaps a vehicle again and again on its way through a recording, and says how soon it knows
// where it is.

#include <algorithm>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_format.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"
#include "slam/evaluation/statistics.h"
#include "tests/bench/bench_main.h"
#include "tests/bench/relocalization_bench_run.h"

namespace semmap::bench {
namespace {

constexpr int kSoon = 5;        // frames
constexpr double kWrong = 1.0;  // metres

struct Arguments {
  RelocalizationOptions options;
  std::string config_file;
  bool json = false;
  bool verbose = false;
};

void AddOptions(CLI::App* app, Arguments* arguments) {
  static const std::map<std::string, SensorType> sensors = {
      {"mono", SensorType::kMono}, {"stereo", SensorType::kStereo}, {"rgbd", SensorType::kRgbd}};
  RelocalizationOptions& options = arguments->options;
  app->add_option("--source", options.bench.source, client::SourceSpecHelp())->required();
  app->add_option("--sensor", options.bench.source_options.sensor, "mono|stereo|rgbd")
      ->required()
      ->transform(CLI::CheckedTransformer(sensors));
  app->add_option("--config", arguments->config_file, "File whose `slam` section is used");
  app->add_option("--frames", options.bench.max_frames, "Use so many frames; 0: all");
  app->add_option("--trials", options.trials, "Of each kind")->check(CLI::Range(1, 1000));
  app->add_option("--black", options.black_frames, "Frames of a blindfold")->check(CLI::Range(1, 1000));
  app->add_option("--distance", options.distance_m, "Metres of a kidnapping")->check(CLI::PositiveNumber);
  app->add_flag("--verbose", arguments->verbose, "Print every trial");
  app->add_flag("--json", arguments->json, "Print JSON instead of a table");
}

nlohmann::json Summary(const std::vector<TrialResult>& results, Ordeal ordeal, int trials) {
  int lost = 0;
  int soon = 0;
  int wrong = 0;
  std::vector<double> frames;
  std::vector<double> errors;
  for (const TrialResult& result : results) {
    if (result.ordeal != ordeal) continue;
    lost += result.was_lost ? 1 : 0;
    if (!result.found_after) continue;
    frames.push_back(*result.found_after);
    errors.push_back(result.error_m);
    soon += *result.found_after <= kSoon ? 1 : 0;
    wrong += result.error_m > kWrong ? 1 : 0;
  }
  return {{"kind", NameOf(ordeal)},
          {"trials", trials},
          {"lost_at_first", lost},
          {"found", frames.size()},
          {"found_soon", soon},
          {"wrong", wrong},
          {"median_frames", frames.empty() ? 0.0 : Percentile(frames, 0.5)},
          {"max_error_m", errors.empty() ? 0.0 : *std::max_element(errors.begin(), errors.end())}};
}

void PrintTable(const nlohmann::json& rows) {
  std::cout << absl::StrFormat("%-10s %7s %6s %6s %9s %6s %13s %11s\n", "kind", "trials", "lost", "found",
                               "in 5", "wrong", "median frame", "max error");
  for (const nlohmann::json& row : rows) {
    std::cout << absl::StrFormat("%-10s %7d %6d %6d %9d %6d %13.1f %9.2f m\n", row["kind"].get<std::string>(),
                                 row["trials"].get<int>(), row["lost_at_first"].get<int>(),
                                 row["found"].get<int>(), row["found_soon"].get<int>(),
                                 row["wrong"].get<int>(), row["median_frames"].get<double>(),
                                 row["max_error_m"].get<double>());
  }
}

void PrintTrials(const std::vector<TrialResult>& results) {
  for (const TrialResult& result : results) {
    std::cout << absl::StrFormat("%-10s frame %5d %s after %d, error %.2f m\n", NameOf(result.ordeal),
                                 result.frame, result.found_after ? "found" : "not found",
                                 result.found_after.value_or(0), result.error_m);
  }
}

absl::Status Run(Arguments& arguments) {
  if (!arguments.config_file.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(arguments.options.bench.config, SlamConfig::FromFile(arguments.config_file));
  }
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<TrialResult> results, RunTrials(arguments.options));
  if (arguments.verbose) PrintTrials(results);
  nlohmann::json rows = nlohmann::json::array();
  for (const Ordeal ordeal : {Ordeal::kBlindfold, Ordeal::kBack, Ordeal::kKidnap})
    rows.push_back(Summary(results, ordeal, arguments.options.trials));
  if (arguments.json) {
    std::cout << rows.dump(2) << "\n";
  } else {
    PrintTable(rows);
  }
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("Benchmark of relocalization on the way through a recording");
  Arguments arguments;
  AddOptions(&app, &arguments);
  return RunMain(app, "relocalization_bench", argc, argv, [&arguments] { return Run(arguments); });
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
