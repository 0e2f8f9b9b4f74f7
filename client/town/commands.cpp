#include "client/town/commands.h"

#include <chrono>
#include <cstdio>
#include <memory>

#include "CLI/CLI.hpp"
#include "absl/strings/str_join.h"
#include "slam/common/status_macros.h"

namespace semmap::town {
namespace {

int Fail(const absl::Status& status) {
  std::fprintf(stderr, "town: %s\n", status.ToString().c_str());
  return 1;
}

absl::Status WriteDrive(const DriveCommand& command) {
  DriveConfig config = command.drive;
  if (!command.rig_file.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(config.rig, RigConfig::FromFile(command.rig_file));
  }
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<TownDrive> drive, TownDrive::Create(config));
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<DatasetWriter> writer,
                          DatasetWriter::Create(command.output, *drive, command.dataset));
  const auto start = std::chrono::steady_clock::now();
  DriveFrame frame;
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool more, drive->Next(&frame));
    if (!more) break;
    SEMMAP_RETURN_IF_ERROR(writer->Write(frame));
    if (drive->frames() % 100 == 0) {
      std::fprintf(stderr, "town: frame %d, %.0f m\n", drive->frames(), drive->simulation().Ego().travelled);
    }
  }
  SEMMAP_RETURN_IF_ERROR(writer->Finish());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  std::printf("%d frames, %.1f m of route %s, %.1f frames a second (%s)\n", drive->frames(),
              drive->simulation().Ego().travelled, config.route.c_str(), drive->frames() / seconds.count(),
              drive->device().c_str());
  return absl::OkStatus();
}

void AddDriveOptions(CLI::App* app, DriveCommand* options) {
  app->add_option("--seed", options->drive.seed, "Seed of the town")->capture_default_str();
  app->add_option("--traffic-seed", options->drive.traffic_seed,
                  "Seed of traffic and sensor errors; 0: the town's");
  app->add_option("--route", options->drive.route, "One of " + absl::StrJoin(RouteNames(), ", "))
      ->capture_default_str();
  app->add_option("--vehicles", options->drive.traffic.vehicles)
      ->check(CLI::Range(0, 200))
      ->capture_default_str();
  app->add_option("--pedestrians", options->drive.traffic.pedestrians)
      ->check(CLI::Range(0, 500))
      ->capture_default_str();
  app->add_option("--frames", options->drive.max_frames, "0: to the end of the route")->capture_default_str();
  app->add_option("--weather", options->drive.weather, "One of " + absl::StrJoin(WeatherNames(), ", "))
      ->capture_default_str();
  app->add_option("--rig", options->rig_file, "YAML file of the sensors")->check(CLI::ExistingFile);
  app->add_flag("--stereo", options->drive.stereo, "A right camera too");
  app->add_flag("--grey", options->dataset.grey, "Grey images instead of colour");
  app->add_flag("!--no-class", options->dataset.mask, "Leave out the class masks");
  app->add_flag("!--no-depth", options->dataset.depth, "Leave out the depth images");
}

void AddDrive(CLI::App* town, int* exit_code, const StreamDrive& stream,
              const std::function<void(CLI::App* drive)>& add_stream_options) {
  auto options = std::make_shared<DriveCommand>();
  CLI::App* app = town->add_subcommand("drive", "Drive a route and write or stream what the vehicle senses");
  AddDriveOptions(app, options.get());
  CLI::Option* output = app->add_option("--output", options->output, "Dataset folder to write");
  if (stream == nullptr) output->required();
  if (add_stream_options) add_stream_options(app);
  app->callback([options, exit_code, stream] {
    if (!options->output.empty()) {
      *exit_code = RunTownDrive(*options);
      return;
    }
    if (!options->rig_file.empty()) {
      auto rig = RigConfig::FromFile(options->rig_file);
      if (!rig.ok()) {
        *exit_code = Fail(rig.status());
        return;
      }
      options->drive.rig = *rig;
    }
    *exit_code = stream(*options);
  });
}

void AddCollect(CLI::App* town, int* exit_code) {
  auto options = std::make_shared<CollectCommand>();
  CLI::App* app = town->add_subcommand("collect", "Collect images with class masks all over the town");
  app->add_option("--seed", options->seed, "Seed of the town")->capture_default_str();
  app->add_option("--output", options->output, "Folder to write")->required();
  app->add_option("--points", options->points, "Spawn points")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app->add_option("--views", options->views, "Images of each point, evenly around")
      ->check(CLI::Range(1, 360))
      ->capture_default_str();
  app->add_option("--vehicles", options->vehicles)->check(CLI::Range(0, 200))->capture_default_str();
  app->add_option("--pedestrians", options->pedestrians)->check(CLI::Range(0, 500))->capture_default_str();
  app->add_option("--weather", options->weather,
                  "One of " + absl::StrJoin(WeatherNames(), ", ") + ", or all (in turns)")
      ->capture_default_str();
  app->add_option("--rig", options->rig_file, "YAML file of the sensors")->check(CLI::ExistingFile);
  app->callback([options, exit_code] { *exit_code = RunTownCollect(*options); });
}

void AddMap(CLI::App* town, int* exit_code) {
  auto options = std::make_shared<MapCommand>();
  CLI::App* app = town->add_subcommand("map", "Draw the town from above, with the routes");
  app->add_option("--seed", options->seed, "Seed of the town")->capture_default_str();
  app->add_option("--output", options->output, "PNG file")->required();
  app->add_option("--pixels-per-metre", options->pixels_per_metre)
      ->check(CLI::Range(0.5, 20.0))
      ->capture_default_str();
  app->callback([options, exit_code] { *exit_code = RunTownMap(*options); });
}

}  // namespace

int RunTownDrive(const DriveCommand& command) {
  const absl::Status status = WriteDrive(command);
  return status.ok() ? 0 : Fail(status);
}

void AddTownCommands(CLI::App* app, int* exit_code, StreamDrive stream,
                     const std::function<void(CLI::App* drive)>& add_stream_options) {
  CLI::App* town = app->add_subcommand("town", "The simulated town");
  town->require_subcommand(1);
  AddDrive(town, exit_code, stream, add_stream_options);
  AddCollect(town, exit_code);
  AddMap(town, exit_code);
}

}  // namespace semmap::town
