// Plays a recording through the SLAM pipeline in this process and says how well and how fast it went.

#include <cstdio>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "slam/common/status_macros.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/semantics/torch/torch_segmenter.h"
#include "tests/bench/bench_main.h"
#include "tests/bench/slam_bench_config.h"
#include "tests/bench/slam_bench_report.h"

namespace semmap::bench {
namespace {

struct Arguments {
  BenchOptions bench;
  std::string config_file;
  std::vector<std::string> settings;
  std::string trajectory_file;
  std::string format = "tum";
  std::string segmentation;
  bool deterministic = false;
  bool json = false;
  int runs = 1;
};

void AddOptions(CLI::App* app, Arguments* arguments) {
  static const std::map<std::string, SensorType> sensors = {
      {"mono", SensorType::kMono}, {"stereo", SensorType::kStereo}, {"rgbd", SensorType::kRgbd}};
  app->add_option("--source", arguments->bench.source, client::SourceSpecHelp())->required();
  app->add_option("--sensor", arguments->bench.source_options.sensor, "mono|stereo|rgbd")
      ->required()
      ->transform(CLI::CheckedTransformer(sensors));
  app->add_option("--camera", arguments->bench.source_options.camera_file, "Camera file (YAML)");
  app->add_option("--config", arguments->config_file, "File whose `slam` section is used");
  app->add_option("--set", arguments->settings,
                  "Change one setting: slam.semantics.penalty=0; may be repeated");
  app->add_flag("--masks", arguments->bench.source_options.class_masks,
                "Use the class masks of the recording (subfolder `class`)");
  app->add_option("--segmentation", arguments->segmentation,
                  "Segment frames with this network (YAML, or default), as slam.segmentation says; "
                  "every frame if that is off");
  app->add_option("--runs", arguments->runs, "How many times; figures are medians")
      ->check(CLI::Range(1, 1000));
  app->add_option("--frames", arguments->bench.max_frames, "Stop after so many frames; 0: all")
      ->check(CLI::NonNegativeNumber);
  app->add_option("--backlog", arguments->bench.backlog, "Keyframes that may wait for the mapper")
      ->check(CLI::NonNegativeNumber);
  app->add_option("--trajectory", arguments->trajectory_file, "Write the final trajectory (of the last run)");
  app->add_option("--format", arguments->format, "Of --trajectory: tum|kitti")
      ->check(CLI::IsMember({"tum", "kitti"}));
  app->add_flag("--realtime", arguments->bench.realtime, "Frames come at their recorded pace");
  app->add_flag("!--no-loops", arguments->bench.close_loops, "Close no loops");
  app->add_flag("--deterministic", arguments->deterministic, "Everything on one thread");
  app->add_flag("--json", arguments->json, "Print JSON instead of a table");
}

absl::Status RunAll(Arguments& arguments) {
  SEMMAP_ASSIGN_OR_RETURN(arguments.bench.config, ReadSlamConfig(arguments.config_file, arguments.settings));
  if (arguments.deterministic) arguments.bench.config.deterministic = true;
  if (!arguments.segmentation.empty()) {
    SegmentationConfig& segmentation = arguments.bench.config.segmentation;
    segmentation.model = arguments.segmentation == "default" ? "" : arguments.segmentation;
    if (segmentation.mode == SegmentationMode::kOff) segmentation.mode = SegmentationMode::kEveryFrame;
    SEMMAP_ASSIGN_OR_RETURN(arguments.bench.segmentation, LoadSegmentation(segmentation));
  }
  std::vector<RunResult> runs;
  for (int i = 0; i < arguments.runs; ++i) {
    SEMMAP_ASSIGN_OR_RETURN(RunResult run, RunOnce(arguments.bench));
    runs.push_back(std::move(run));
  }
  if (!arguments.trajectory_file.empty()) {
    const auto format = arguments.format == "tum" ? TrajectoryFormat::kTum : TrajectoryFormat::kKitti;
    SEMMAP_RETURN_IF_ERROR(WriteTrajectory(arguments.trajectory_file, runs.back().trajectory, format));
  }
  std::cout << (arguments.json ? ReportJson(runs).dump(2) + "\n" : ReportTable(runs));
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("Benchmark of the SLAM pipeline over one recording");
  Arguments arguments;
  AddOptions(&app, &arguments);
  return RunMain(app, "slam_bench", argc, argv, [&] { return RunAll(arguments); });
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
