// Kills semmapd with SIGKILL at random instants of drives, also inside loop closing, copies, imports, backups
// and migrations, starts it again on the same data, and looks whether every map opens, is sound, holds every
// frame and keyframe that was acknowledged, and finds their images.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>

#include <spdlog/spdlog.h>

#include "CLI/CLI.hpp"
#include "client/sources/open_source.h"
#include "recording.h"
#include "report.h"
#include "rounds.h"
#include "slam/common/status_macros.h"
#include "tests/bench/bench_main.h"

namespace semmap::kill_test {
namespace {

// Of the round trip, where no other source is given.
constexpr size_t kStreetFrames = 40;

struct Arguments {
  int kills = 200;
  uint64_t seed = 1;
  std::string source;
  SensorType sensor = SensorType::kStereo;
  size_t max_frames = 60;
  std::string config = std::string(SEMMAP_SOURCE_DIR) + "/tests/e2e/kill/semmapd.yaml";
  std::string keep;
  bool json = false;
};

// A directory that goes at the end unless it is to be kept.
class Directory {
 public:
  explicit Directory(const std::string& keep) : keep_(!keep.empty()) {
    if (keep_) {
      path_ = keep;
      return;
    }
    std::string name = (std::filesystem::temp_directory_path() / "semmap-kill-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Directory() {
    std::error_code ignored;
    if (!keep_) std::filesystem::remove_all(path_, ignored);
  }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;

  const std::string& path() const { return path_; }

 private:
  bool keep_;
  std::string path_;
};

absl::Status Run(const Arguments& arguments) {
  SEMMAP_ASSIGN_OR_RETURN(const Recording round, DrawRoundTrip());
  Recording street = round;
  street.frames.resize(std::min(street.frames.size(), kStreetFrames));
  if (!arguments.source.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(street, ReadRecording(arguments.source, arguments.sensor, arguments.max_frames));
  }
  const Directory directory(arguments.keep);
  Rounds rounds({directory.path(), arguments.config, arguments.seed}, street, round);
  SEMMAP_RETURN_IF_ERROR(rounds.Prepare());
  for (int i = 0; i < arguments.kills; ++i) {
    SEMMAP_RETURN_IF_ERROR(rounds.KillOnce());
    if ((i + 1) % static_cast<int>(kPhases.size()) == 0) std::cerr << i + 1 << " kills\n";
  }
  SEMMAP_RETURN_IF_ERROR(rounds.Finish());
  const nlohmann::json report = ReportJson(rounds, arguments.seed);
  std::cout << (arguments.json ? report.dump(2) + "\n" : ReportTable(report));
  if (report["failures"].empty()) return absl::OkStatus();
  return absl::DataLossError(std::to_string(report["failures"].size()) + " failures");
}

int Main(int argc, char** argv) {
  static const std::map<std::string, SensorType> sensors = {{"mono", SensorType::kMono},
                                                            {"stereo", SensorType::kStereo}};
  Arguments arguments;
  CLI::App app("Kills semmapd and looks what is left");
  app.add_option("--kills", arguments.kills, "How many times")->check(CLI::PositiveNumber);
  app.add_option("--seed", arguments.seed, "Of the instants");
  app.add_option("--source", arguments.source,
                 std::string("What vehicles drive; default a drawn room. ") + client::SourceSpecHelp());
  app.add_option("--sensor", arguments.sensor, "mono|stereo; default stereo")
      ->transform(CLI::CheckedTransformer(sensors));
  app.add_option("--frames", arguments.max_frames, "Frames of the source to drive");
  app.add_option("--config", arguments.config, "Configuration of semmapd")->check(CLI::ExistingFile);
  app.add_option("--directory", arguments.keep, "Work in this directory and leave it there");
  app.add_flag("--json", arguments.json, "Print JSON instead of a table");
  // What the test itself does to databases is not to be read among its report.
  spdlog::set_level(spdlog::level::warn);
  return bench::RunMain(app, "kill_test", argc, argv, [&] { return Run(arguments); });
}

}  // namespace
}  // namespace semmap::kill_test

int main(int argc, char** argv) { return semmap::kill_test::Main(argc, argv); }
