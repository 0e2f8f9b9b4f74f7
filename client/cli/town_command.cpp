// semmap town: the simulated town. `town drive` without --output streams to a server as a vehicle would.

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/drive_session.h"
#include "client/cli/town_source.h"
#include "client/town/commands.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct StreamArguments {
  DriveSessionOptions session;
  TownSourceOptions source;
  std::string truth;  // file to write; empty: none
};

void AddStreamOptions(CLI::App& command, StreamArguments* arguments) {
  AddDriveSessionOptions(command, &arguments->session);
  command
      .add_option("--jpeg", arguments->source.jpeg_quality, "Send JPEG of this quality; without, raw pixels")
      ->check(CLI::Range(1, 100));
  command.add_option("--truth", arguments->truth,
                     "Write the true poses here (TUM format); they are never sent");
  command.add_flag("--send-class", arguments->source.class_mask, "Send the class masks too");
}

absl::Status StreamTownDrive(const StreamArguments& arguments, const town::DriveConfig& config,
                             const Console& console) {
  if (arguments.session.map.empty()) {
    return UsageError(
        "town drive needs --output DIR to write a dataset, or --map NAME to stream to a server");
  }
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<TownSource> source,
                          TownSource::Create(config, arguments.source));
  const absl::Status driven = DriveSession(*source, arguments.session, console);
  if (!arguments.truth.empty()) {
    SEMMAP_RETURN_IF_ERROR(WriteTrajectory(arguments.truth, *source->ground_truth(), TrajectoryFormat::kTum));
  }
  return driven;
}

}  // namespace

void AddTownCommand(CLI::App& parent, Action* action, int* exit_code) {
  auto arguments = std::make_shared<StreamArguments>();
  const auto stream = [arguments, action](const town::DriveCommand& command) {
    arguments->source.grey = command.dataset.grey;
    if (arguments->session.vehicle.empty()) {
      arguments->session.vehicle = absl::StrCat("town-", command.drive.route);
    }
    *action = [arguments, config = command.drive](const Console& console) {
      return StreamTownDrive(*arguments, config, console);
    };
    return kExitOk;
  };
  town::AddTownCommands(&parent, exit_code, stream,
                        [arguments](CLI::App* drive) { AddStreamOptions(*drive, arguments.get()); });
}

}  // namespace semmap::client
