#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/cli/console.h"
#include "client/cli/drive_runner.h"
#include "client/cli/server_options.h"
#include "client/sources/frame_source.h"
#include "semmap/v1/session.pb.h"
#include "slam/evaluation/trajectory_io.h"

namespace semmap::client {

// What every command asks for that drives a vehicle through a session, wherever its frames come from.
struct DriveSessionOptions {
  ServerOptions server;
  v1::SessionMode mode = v1::SESSION_MODE_MAP;
  v1::OverloadPolicy policy = v1::OVERLOAD_POLICY_BLOCK;
  std::string map;
  std::string vehicle;
  std::string trajectory;  // file to write; empty: none
  TrajectoryFormat format = TrajectoryFormat::kTum;
  uint64_t max_frames = 0;  // 0: all; set by the commands
  bool realtime = false;
  bool pipelined = false;
  bool online = false;
  bool no_resume = false;
  bool json = false;
};

// Adds all but max_frames. --map and --vehicle are not required here.
void AddDriveSessionOptions(CLI::App& command, DriveSessionOptions* options);

// Connects, plays the source to its end, writes the trajectory if asked for, and prints the summary: tracked
// frames, times, and, where the source knows the truth, the error of the trajectory that the server holds in
// the end (aligned by a similarity for one camera, else by a rigid motion).
absl::Status DriveSession(FrameSource& source, const DriveSessionOptions& options, const Console& console);

}  // namespace semmap::client
