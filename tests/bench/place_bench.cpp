// How often place recognition finds the right place, against exact search, and how its time grows with the
// map.

#include <filesystem>
#include <iostream>

#include "CLI/CLI.hpp"
#include "slam/common/status_macros.h"
#include "tests/bench/bench_main.h"
#include "tests/bench/place_bench_recall.h"
#include "tests/bench/place_bench_report.h"
#include "tests/bench/place_bench_scaling.h"

namespace semmap::bench {
namespace {

struct Arguments {
  std::vector<std::string> recordings;
  std::string vocabulary = DefaultVocabularyPath();
  int features = 2000;
  size_t oracle_descriptors = 300;
  ScalingOptions scaling;
  bool no_scaling = false;
  bool json = false;
};

void AddOptions(CLI::App* app, Arguments* arguments) {
  app->add_option("--recording", arguments->recordings,
                  "FOLDER[,QUERY_FOLDER][@STEP[:SPLIT]]: every STEP-th image; those before number SPLIT are "
                  "the database "
                  "and the later ones queries, or the second folder's, or every other one")
      ->required();
  app->add_option("--vocabulary", arguments->vocabulary, "Instead of the one that ships");
  app->add_option("--features", arguments->features, "Keypoints of an image")->check(CLI::Range(100, 10000));
  app->add_option("--oracle-descriptors", arguments->oracle_descriptors, "Of each query for exact search")
      ->check(CLI::Range(1, 10000));
  app->add_option("--sizes", arguments->scaling.sizes, "Numbers of keyframes to time queries at, rising");
  app->add_option("--queries", arguments->scaling.queries, "To time at each")->check(CLI::Range(1, 100000));
  app->add_flag("--no-retrieval-times", arguments->no_scaling, "Only recall");
  app->add_flag("--json", arguments->json, "Print JSON instead of tables");
}

absl::Status Run(const Arguments& arguments) {
  PlaceReport report;
  report.vocabulary = std::filesystem::path(arguments.vocabulary).filename();
  SEMMAP_ASSIGN_OR_RETURN(const auto vocabulary, Vocabulary::Load(arguments.vocabulary));
  report.vocabulary_bytes = std::filesystem::file_size(arguments.vocabulary);
  report.words = vocabulary->words();
  report.load_ms = MeasureLoad(arguments.vocabulary);
  std::vector<std::vector<Descriptor>> images;
  for (const std::string& text : arguments.recordings) {
    SEMMAP_ASSIGN_OR_RETURN(const RecordingSpec spec, ParseRecordingSpec(text));
    SEMMAP_ASSIGN_OR_RETURN(const Recording recording, ReadRecording(spec, arguments.features));
    report.recall.push_back(MeasureRecall(recording, vocabulary, arguments.oracle_descriptors));
    for (const DescribedFrame& frame : recording.frames) images.push_back(frame.descriptors);
  }
  if (!arguments.no_scaling) report.scaling = MeasureScaling(images, vocabulary, arguments.scaling);
  std::cout << (arguments.json ? ReportJson(report).dump(2) + "\n" : ReportTables(report));
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("Benchmark of place recognition");
  Arguments arguments;
  AddOptions(&app, &arguments);
  return RunMain(app, "place_bench", argc, argv, [&] { return Run(arguments); });
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
