#pragma once

#include <functional>
#include <string>

#include "CLI/App.hpp"
#include "client/town/dataset_writer.h"
#include "client/town/drive.h"

namespace semmap::town {

// What `town drive` was asked for.
struct DriveCommand {
  DriveConfig drive;
  DatasetOptions dataset;
  std::string output;  // dataset folder
  std::string rig_file;
};

// Sends the frames of a drive somewhere else than into a folder: the program hands in what streams them to a
// server. Called instead of the writer when no --output is given, with the rig's file read. Returns the exit
// code.
using StreamDrive = std::function<int(const DriveCommand&)>;

// Adds the command `town` with drive, collect and map to a program. Each sets *exit_code when it was run.
// Without `stream`, `drive` requires --output. The options live as long as `app`.
void AddTownCommands(CLI::App* app, int* exit_code, StreamDrive stream = nullptr,
                     const std::function<void(CLI::App* drive)>& add_stream_options = nullptr);

// The commands themselves; exit codes as usual: 0 done, 1 failed, with the reason on standard error.
int RunTownDrive(const DriveCommand& command);

struct CollectCommand {
  uint64_t seed = 1;
  std::string output;
  std::string weather = "noon";
  std::string rig_file;
  int points = 154;
  int views = 24;  // of each point, evenly around
  int vehicles = 40;
  int pedestrians = 60;
};
int RunTownCollect(const CollectCommand& command);

struct MapCommand {
  uint64_t seed = 1;
  std::string output;
  double pixels_per_metre = 3;
};
int RunTownMap(const MapCommand& command);

}  // namespace semmap::town
