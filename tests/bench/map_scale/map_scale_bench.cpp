// How a map of ten thousand keyframes is opened, searched, driven in and queried, under a limit of memory: a
// drive is laid side by side until the map is large, then measured. `map_scale_bench --work DIR` keeps the
// maps in DIR for the next run.

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>

#include "CLI/CLI.hpp"
#include "slam/common/status_macros.h"
#include "tests/bench/map_scale/map_scale_copies.h"
#include "tests/bench/map_scale/map_scale_drive.h"
#include "tests/bench/map_scale/map_scale_measure.h"
#include "tests/bench/map_scale/map_scale_report.h"

namespace semmap::bench {
namespace {

void AddOptions(CLI::App* app, MapScaleOptions* options, bool* json) {
  static const std::map<std::string, SensorType> sensors = {{"mono", SensorType::kMono},
                                                            {"stereo", SensorType::kStereo}};
  app->add_option("--work", options->work, "Directory for the maps; what is there already is used again")
      ->required();
  app->add_option("--source", options->source, "The drive: town:ROUTE, or KIND:PATH of a recording");
  app->add_option("--sensor", options->sensor, "mono|stereo")->transform(CLI::CheckedTransformer(sensors));
  app->add_option("--frames", options->frames, "Of the drive, at most")->check(CLI::PositiveNumber);
  app->add_option("--keyframes", options->keyframes, "The map has at least so many");
  app->add_option("--points", options->points, "The map has at least so many");
  app->add_option("--memory", options->memory_mb, "MB for the map")->check(CLI::Range(1, 1 << 20));
  app->add_option("--queries", options->queries, "Pictures that are looked for")->check(CLI::PositiveNumber);
  app->add_flag("--whole", options->whole, "Load the whole map instead of parts, whatever it takes");
  app->add_flag("--json", *json, "Print JSON instead of a table");
}

absl::Status MakeMaps(const MapScaleOptions& options) {
  SEMMAP_RETURN_IF_ERROR(MakeDrive(options));
  return MakeLargeMap(options);
}

int Report(const absl::Status& status) {
  if (status.ok()) return 0;
  std::fprintf(stderr, "map_scale_bench: %s\n", status.ToString().c_str());
  return 1;
}

// In a process of its own, whose memory goes with it.
bool MakeMapsElsewhere(const MapScaleOptions& options) {
  const pid_t child = fork();
  if (child < 0) return false;
  if (child == 0) {
    const int code = Report(MakeMaps(options));
    std::fflush(nullptr);
    _exit(code);
  }
  int state = 0;
  return waitpid(child, &state, 0) == child && WIFEXITED(state) && WEXITSTATUS(state) == 0;
}

int Main(int argc, char** argv) {
  CLI::App app("Benchmark of a large stored map");
  MapScaleOptions options;
  bool json = false;
  AddOptions(&app, &options, &json);
  CLI11_PARSE(app, argc, argv);
  options.work = std::filesystem::absolute(options.work);
  std::filesystem::create_directories(options.work);
  if (!MakeMapsElsewhere(options)) return 1;
  const auto result = Measure(options);
  if (!result.ok()) return Report(result.status());
  std::cout << (json ? MapScaleJson(*result).dump(2) + "\n" : MapScaleTable(*result));
  return 0;
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
