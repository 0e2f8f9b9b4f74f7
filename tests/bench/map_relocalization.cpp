// Asks a server where the pictures of a recording were taken, in a map made of another, and compares the
// answers with the truth, which both recordings know in one frame.

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_format.h"
#include "client/cli/relocalization_report.h"
#include "client/client.h"
#include "client/sources/open_source.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"
#include "slam/evaluation/recall.h"
#include "slam/evaluation/statistics.h"
#include "tests/bench/bench_main.h"
#include "tests/bench/map_queries.h"
#include "tests/bench/map_truth.h"

namespace semmap::bench {
namespace {

constexpr double kWrong = 5.0;  // metres
// A picture is from elsewhere when no keyframe stood within.
constexpr double kFar = 30.0;
// The three usual ones, and the one that is asked of real frames.
constexpr std::array<PoseThreshold, 4> kThresholds = {{kLocalizationThresholds[0],
                                                       {0.5, 2.0 / 180.0 * std::numbers::pi},
                                                       kLocalizationThresholds[1],
                                                       kLocalizationThresholds[2]}};
constexpr std::array kThresholdNames = {"0.25/2", "0.5/2", "0.5/5", "5/10"};
// Between answers to the same questions.
constexpr double kSame = 1e-9;

struct Arguments {
  std::string server = "localhost:50051";
  std::string map_times;  // times.txt of the recording that became the map
  std::string map_truth;  // its poses in the common frame, KITTI's format
  bool with_scale = false;
  QueryOptions query;
  std::string answers;  // file to write
  std::string compare;  // answers of an earlier run
  bool json = false;
};

nlohmann::json Shares(const std::vector<PoseError>& errors, size_t queries) {
  const std::vector<double> recall = RecallAtThresholds(errors, queries, kThresholds);
  nlohmann::json shares;
  for (size_t i = 0; i < kThresholds.size(); ++i) shares[kThresholdNames[i]] = recall[i];
  return shares;
}

nlohmann::json Summarize(const std::vector<Answer>& answers) {
  std::map<std::string, size_t> counts = {
      {"in_map", 0}, {"elsewhere", 0}, {"found", 0}, {"found_elsewhere", 0}, {"wrong_by_over_5m", 0}};
  std::vector<PoseError> errors;
  std::vector<PoseError> local_errors;
  std::vector<double> times;
  std::vector<double> distances;
  std::map<std::string, int> results;
  for (const Answer& answer : answers) {
    const bool elsewhere = answer.distance_m > kFar;
    counts["in_map"] += answer.in_map ? 1 : 0;
    counts["elsewhere"] += elsewhere ? 1 : 0;
    counts["found"] += answer.found() ? 1 : 0;
    counts["found_elsewhere"] += answer.found() && elsewhere ? 1 : 0;
    counts["wrong_by_over_5m"] += answer.found() && answer.error.translation_m > kWrong ? 1 : 0;
    if (answer.found() && answer.in_map) {
      errors.push_back(answer.error);
      local_errors.push_back(answer.local_error);
      distances.push_back(answer.error.translation_m);
    }
    times.push_back(answer.response.processing_ms());
    ++results[client::ResultName(answer.response.result())];
  }
  nlohmann::json summary(counts);
  summary["queries"] = answers.size();
  summary["found_in_map"] = errors.size();
  summary["shares"] = Shares(errors, counts["in_map"]);
  summary["local_shares"] = Shares(local_errors, counts["in_map"]);
  summary["median_error_m"] = Percentile(distances, 0.5);
  summary["median_ms"] = Percentile(times, 0.5);
  summary["p95_ms"] = Percentile(times, 0.95);
  summary["results"] = results;
  return summary;
}

std::string ShareColumns(const nlohmann::json& shares) {
  std::string columns;
  for (const char* name : kThresholdNames)
    absl::StrAppendFormat(&columns, " %6.1f%%", 100 * shares[name].get<double>());
  return columns;
}

void PrintTable(const nlohmann::json& s, bool local) {
  std::cout << absl::StrFormat("%8s %7s %7s", "queries", "in map", "found");
  for (const char* name : kThresholdNames) std::cout << absl::StrFormat(" %7s", name);
  std::cout << absl::StrFormat(" %10s %7s %8s %8s\n", "elsewhere", "wrong", "ms", "p95 ms");
  std::cout << absl::StrFormat("%8d %7d %7d", s["queries"].get<int>(), s["in_map"].get<int>(),
                               s["found_in_map"].get<int>())
            << ShareColumns(s["shares"])
            << absl::StrFormat(" %6d/%-3d %7d %8.1f %8.1f\n", s["found_elsewhere"].get<int>(),
                               s["elsewhere"].get<int>(), s["wrong_by_over_5m"].get<int>(),
                               s["median_ms"].get<double>(), s["p95_ms"].get<double>());
  if (local)
    std::cout << absl::StrFormat("%24s", "aligned around each") << ShareColumns(s["local_shares"]) << "\n";
}

nlohmann::json AnswersJson(const std::vector<Answer>& answers) {
  nlohmann::json all = nlohmann::json::array();
  for (const Answer& answer : answers) {
    nlohmann::json json = client::RelocalizationJson(absl::StrFormat("%d", answer.frame), answer.response);
    json["distance_m"] = answer.distance_m;
    json["in_map"] = answer.in_map;
    if (answer.response.has_map_from_camera()) {
      json["error_m"] = answer.error.translation_m;
      json["local_error_m"] = answer.local_error.translation_m;
      json["error_deg"] = answer.error.rotation_rad * 180 / std::numbers::pi;
    }
    all.push_back(std::move(json));
  }
  return all;
}

// The greatest difference between two lists of answers: of any number of a pose, infinite where one has an
// answer that the other has not.
double Difference(const nlohmann::json& first, const nlohmann::json& second) {
  if (first.size() != second.size()) return std::numeric_limits<double>::infinity();
  double greatest = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    if (first[i]["image"] != second[i]["image"] || first[i]["result"] != second[i]["result"])
      return std::numeric_limits<double>::infinity();
    if (!first[i].contains("position")) continue;
    for (const char* part : {"position", "rotation"}) {
      for (size_t n = 0; n < first[i][part].size(); ++n) {
        greatest =
            std::max(greatest, std::abs(first[i][part][n].get<double>() - second[i][part][n].get<double>()));
      }
    }
  }
  return greatest;
}

absl::Status Run(const Arguments& arguments) {
  client::ConnectOptions options;
  options.address = arguments.server;
  SEMMAP_ASSIGN_OR_RETURN(const auto connection, client::Connection::Open(options));
  client::Client client(connection);
  SEMMAP_ASSIGN_OR_RETURN(const MapTruth map, MapTruth::Read(client, arguments.query.map, arguments.map_times,
                                                             arguments.map_truth, arguments.with_scale));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<Answer> answers,
                          AskAll(client, connection, arguments.query, map));
  nlohmann::json summary = Summarize(answers);
  const nlohmann::json all = AnswersJson(answers);
  if (!arguments.answers.empty()) std::ofstream(arguments.answers) << all.dump(1) << "\n";
  if (!arguments.compare.empty()) {
    std::ifstream file(arguments.compare);
    const nlohmann::json earlier = nlohmann::json::parse(file, nullptr, false);
    if (earlier.is_discarded()) return absl::NotFoundError(arguments.compare + " cannot be read");
    summary["difference"] = Difference(earlier, all);
  }
  if (arguments.json) {
    std::cout << summary.dump(2) << "\n";
  } else {
    PrintTable(summary, arguments.with_scale);
  }
  if (!summary.contains("difference")) return absl::OkStatus();
  const double difference = summary["difference"].get<double>();
  if (!arguments.json) std::cout << absl::StrFormat("greatest difference %.3g\n", difference);
  return difference < kSame ? absl::OkStatus() : absl::DataLossError("the answers are not those of before");
}

int Main(int argc, char** argv) {
  static const std::map<std::string, SensorType> sensors = {{"mono", SensorType::kMono},
                                                            {"stereo", SensorType::kStereo}};
  Arguments arguments;
  CLI::App app("Relocalization in a stored map, through the service");
  app.add_option("--server", arguments.server, "HOST:PORT");
  app.add_option("--map", arguments.query.map, "Name of the map")->required();
  app.add_option("--map-times", arguments.map_times, "times.txt of the recording that became the map")
      ->required();
  app.add_option("--map-truth", arguments.map_truth, "Its true poses, KITTI's format")->required();
  app.add_option("--query", arguments.query.source, client::SourceSpecHelp())->required();
  app.add_option("--query-truth", arguments.query.truth, "True poses of the pictures, in the same frame")
      ->required();
  app.add_option("--sensor", arguments.query.sensor, "mono|stereo; default mono")
      ->transform(CLI::CheckedTransformer(sensors));
  app.add_flag("--with-scale", arguments.with_scale, "Align by a similarity: maps of one camera");
  app.add_option("--every", arguments.query.every, "Ask about every so many-th picture")
      ->check(CLI::PositiveNumber);
  app.add_option("--skip", arguments.query.skip, "Leave out so many at first");
  app.add_flag("--drive", arguments.query.drive,
               "Drive the whole recording through a LOCALIZE session instead");
  app.add_flag("--any-heading", arguments.query.any_heading,
               "Count places as in the map that it saw from the other direction");
  app.add_option("--answers", arguments.answers, "Write all answers to this file (JSON)");
  app.add_option("--compare", arguments.compare, "Say how far they are from those in this file");
  app.add_flag("--json", arguments.json, "Print JSON instead of a table");
  return RunMain(app, "map_relocalization", argc, argv, [&] { return Run(arguments); });
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
