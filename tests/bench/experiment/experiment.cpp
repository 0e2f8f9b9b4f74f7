// Repeats the paper's experiment in the simulated town: three routes, several seeds of traffic, the base
// algorithm and the semantic one on the same frames. Can be stopped and goes on where it was.

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "tests/bench/bench_main.h"
#include "tests/bench/experiment/experiment_figures.h"
#include "tests/bench/experiment/experiment_report.h"
#include "tests/bench/experiment/files.h"
#include "tests/bench/experiment/recorded_drive.h"
#include "tests/bench/experiment/segmenter_loader.h"
#include "tests/bench/experiment/variant_run.h"
#include "tests/bench/slam_bench_config.h"

namespace semmap::bench {
namespace {

struct Arguments {
  std::string folder;
  std::vector<std::string> routes = {"1", "2", "3"};
  std::vector<uint64_t> seeds = {1, 2, 3, 4, 5};
  std::vector<int> runs = {1};
  std::vector<std::string> variants = {"base", "paper", "semmap", "perfect", "perfect-semmap"};
  std::string config_file;
  std::vector<std::string> settings;
  std::string model;
  std::string model_name = "street";
  std::string tag;
  DriveSetup setup;
  int frame_step = 1;
  int threads = 0;
  bool report_only = false;
  bool quiet = false;
};

void AddOptions(CLI::App* app, Arguments* arguments) {
  std::vector<std::string> names;
  std::string variants = "Variants to run and to report:";
  for (const Variant& variant : AllVariants()) {
    names.push_back(variant.name);
    absl::StrAppend(&variants, " ", variant.name, " (", variant.description, ")");
  }
  app->add_option("--output", arguments->folder, "Folder of drives, results, figures; what is there is kept")
      ->required();
  app->add_option("--routes", arguments->routes, "Routes of the town")->delimiter(',');
  app->add_option("--seeds", arguments->seeds, "Seeds of traffic")->delimiter(',');
  app->add_option("--runs", arguments->runs,
                  "Numbers of the runs over each drive; each begins two frames later than the one before")
      ->delimiter(',');
  app->add_option("--variants", arguments->variants, variants)->delimiter(',')->check(CLI::IsMember(names));
  app->add_option("--config", arguments->config_file, "File whose `slam` section is used");
  app->add_option("--set", arguments->settings,
                  "Change one setting: slam.orb.features=2000; may be repeated");
  app->add_option("--model", arguments->model,
                  "Description of a segmentation model (YAML); default: semmap's own");
  app->add_option("--model-name", arguments->model_name, "Under which its masks are kept");
  app->add_option("--tag", arguments->tag, "Keeps results of other settings apart");
  app->add_option("--vehicles", arguments->setup.vehicles)->check(CLI::Range(0, 200));
  app->add_option("--pedestrians", arguments->setup.pedestrians)->check(CLI::Range(0, 500));
  app->add_option("--weather", arguments->setup.weather);
  app->add_option("--frames", arguments->setup.max_frames,
                  "Stop each drive after so many frames; 0: whole routes")
      ->check(CLI::NonNegativeNumber);
  app->add_option("--frame-step", arguments->frame_step, "Use every so many-th frame")
      ->check(CLI::Range(1, 100));
  app->add_option("--threads", arguments->threads, "Of the segmentation; 0: one for each core");
  app->add_flag("--report-only", arguments->report_only, "Only report what is there");
  app->add_flag("--quiet", arguments->quiet, "No progress");
}

class Experiment {
 public:
  explicit Experiment(const Arguments& arguments) : arguments_(arguments) {}

  absl::Status Run() {
    for (const char* part : {"drives", "results", "figures"})
      SEMMAP_RETURN_IF_ERROR(MakeFolders(absl::StrCat(arguments_.folder, "/", part)));
    SEMMAP_ASSIGN_OR_RETURN(options_.config, ReadSlamConfig(arguments_.config_file, arguments_.settings));
    options_.model = arguments_.model_name;
    options_.frame_step = arguments_.frame_step;
    // All routes of one seed before the next seed, so that early reports say something of each route.
    for (const uint64_t seed : arguments_.seeds) {
      for (const std::string& route : arguments_.routes) {
        for (const int run : arguments_.runs) SEMMAP_RETURN_IF_ERROR(RunDrive({route, seed}, run));
      }
    }
    return Report();
  }

 private:
  std::string ResultPath(const DriveKey& key, int run, const std::string& variant) const {
    const std::string tag = arguments_.tag.empty() ? "" : "_" + arguments_.tag;
    return absl::StrCat(arguments_.folder, "/results/", key.Name(), "_run", run, "_", variant, tag, ".json");
  }

  std::vector<Variant> Missing(const DriveKey& key, int run) const {
    std::vector<Variant> missing;
    for (const std::string& name : arguments_.variants) {
      if (!FileExists(ResultPath(key, run, name))) missing.push_back(*FindVariant(name));
    }
    return missing;
  }

  std::function<void(int)> Progress(const std::string& what) const {
    return [this, what](int frame) {
      if (!arguments_.quiet && frame % 100 == 0) std::cerr << what << ": frame " << frame << "\n";
    };
  }

  absl::StatusOr<RecordedDrive> Drive(const DriveKey& key) {
    if (world_ == nullptr)
      world_ = std::make_unique<town::World>(town::NetworkConfig(), arguments_.setup.town_seed);
    return RecordedDrive::Make(arguments_.folder + "/drives", key, arguments_.setup, *world_,
                               Progress("drawing " + key.Name()));
  }

  absl::Status Segment(const RecordedDrive& drive) {
    if (segmenter_ == nullptr) {
      SEMMAP_ASSIGN_OR_RETURN(segmenter_, LoadSegmenter(arguments_.model, arguments_.threads));
    }
    return drive.Segment(arguments_.model_name, segmenter_.get(), arguments_.frame_step,
                         Progress("segmenting " + drive.key().Name()));
  }

  absl::Status RunDrive(const DriveKey& key, int run) {
    const std::vector<Variant> missing = Missing(key, run);
    options_.run = run;
    if (arguments_.report_only || missing.empty()) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(const RecordedDrive drive, Drive(key));
    const bool needs_model = std::any_of(missing.begin(), missing.end(),
                                         [](const Variant& v) { return v.masks == MaskSource::kModel; });
    if (needs_model) SEMMAP_RETURN_IF_ERROR(Segment(drive));
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<VariantResult> results,
                            RunVariants(drive, missing, options_, Progress("running " + key.Name())));
    for (const VariantResult& result : results)
      SEMMAP_RETURN_IF_ERROR(WriteJson(ResultPath(key, run, result.variant), ToJson(result)));
    return absl::OkStatus();
  }

  absl::Status ReadResultsOf(const DriveKey& key, int run, std::vector<VariantResult>* results) const {
    for (const std::string& variant : arguments_.variants) {
      const std::string path = ResultPath(key, run, variant);
      if (!FileExists(path)) continue;
      SEMMAP_ASSIGN_OR_RETURN(const nlohmann::json json, ReadJson(path));
      SEMMAP_ASSIGN_OR_RETURN(results->emplace_back(), ResultFromJson(json));
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<VariantResult>> ReadResults() const {
    std::vector<VariantResult> results;
    for (const std::string& route : arguments_.routes) {
      for (const uint64_t seed : arguments_.seeds) {
        for (const int run : arguments_.runs)
          SEMMAP_RETURN_IF_ERROR(ReadResultsOf({route, seed}, run, &results));
      }
    }
    return results;
  }

  absl::Status Draw(const DriveKey& key, const std::vector<VariantResult>& results) {
    std::vector<const VariantResult*> own;
    for (const VariantResult& result : results) {
      if (result.route == key.route && result.traffic_seed == key.traffic_seed &&
          result.run == arguments_.runs.front()) {
        own.push_back(&result);
      }
    }
    if (own.empty()) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(const RecordedDrive drive, Drive(key));
    const std::string tag = arguments_.tag.empty() ? "" : "_" + arguments_.tag;
    return WriteFigures(absl::StrCat(arguments_.folder, "/figures/", key.Name(), tag, ".png"),
                        absl::StrCat("Route ", key.route, ", traffic ", key.traffic_seed), drive.truth(),
                        own);
  }

  absl::Status Report() {
    SEMMAP_ASSIGN_OR_RETURN(const std::vector<VariantResult> results, ReadResults());
    for (const uint64_t seed : arguments_.seeds) {
      for (const std::string& route : arguments_.routes) SEMMAP_RETURN_IF_ERROR(Draw({route, seed}, results));
    }
    std::cout << ReportText(results, arguments_.variants);
    const std::string tag = arguments_.tag.empty() ? "" : "_" + arguments_.tag;
    return WriteJson(absl::StrCat(arguments_.folder, "/report", tag, ".json"),
                     ReportJson(results, arguments_.variants));
  }

  const Arguments& arguments_;
  RunOptions options_;
  std::unique_ptr<town::World> world_;
  std::unique_ptr<Segmenter> segmenter_;
};

int Main(int argc, char** argv) {
  CLI::App app("The paper's experiment in the simulated town");
  Arguments arguments;
  AddOptions(&app, &arguments);
  return RunMain(app, "experiment", argc, argv, [&arguments] { return Experiment(arguments).Run(); });
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
