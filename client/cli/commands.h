#pragma once

#include <functional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/cli/console.h"

namespace semmap::client {

// What the chosen command does; set while the command line is parsed, run afterwards.
using Action = std::function<absl::Status(const Console& console)>;

// Each adds its command below `parent`; when the command is chosen, it sets `action`. The options' storage is
// kept alive by the callbacks.
void AddDriveCommand(CLI::App& parent, Action* action);
void AddMapsCommand(CLI::App& parent, Action* action);
void AddMapCommand(CLI::App& parent, Action* action);
// Below `map`: rename, copy, check, repair.
void AddMapCareCommands(CLI::App& map_command, Action* action);
// Below `map`: merge, optimize, prune.
void AddMapReworkCommands(CLI::App& map_command, Action* action);
// Below `map`: update, anchor.
void AddMapUpdateCommands(CLI::App& map_command, Action* action);
void AddPointsCommand(CLI::App& parent, Action* action);
void AddExportCommand(CLI::App& parent, Action* action);
void AddImportCommand(CLI::App& parent, Action* action);
void AddWatchCommand(CLI::App& parent, Action* action);
void AddPictureCommand(CLI::App& parent, Action* action);
void AddKeyFramesCommand(CLI::App& parent, Action* action);
void AddTrajectoryCommand(CLI::App& parent, Action* action);
void AddRelocalizeCommand(CLI::App& parent, Action* action);
void AddEvalCommand(CLI::App& parent, Action* action);
// Below `eval`: segmentation.
void AddEvalSegmentationCommand(CLI::App& eval_command, Action* action);
void AddTrainVocabularyCommand(CLI::App& parent, Action* action);
// `town`, whose drive also streams to a server. The other town commands do their work while the line is
// parsed and set *exit_code.
void AddTownCommand(CLI::App& parent, Action* action, int* exit_code);

// The program `semmap` without its name; returns the exit code: 0 done, 1 failed, 2 called in a wrong way.
int RunCommandLine(std::vector<std::string> arguments, const Console& console);

}  // namespace semmap::client
