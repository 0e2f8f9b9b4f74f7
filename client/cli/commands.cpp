#include "client/cli/commands.h"

#include <algorithm>

namespace semmap::client {
namespace {

void AddCommands(CLI::App& app, Action* action) {
  app.require_subcommand(1);
  app.set_help_all_flag("--help-all", "Help of all commands");
  AddDriveCommand(app, action);
  AddMapsCommand(app, action);
  AddMapCommand(app, action);
  AddPointsCommand(app, action);
  AddExportCommand(app, action);
  AddImportCommand(app, action);
  AddPictureCommand(app, action);
  AddWatchCommand(app, action);
  AddKeyFramesCommand(app, action);
  AddTrajectoryCommand(app, action);
  AddRelocalizeCommand(app, action);
  AddEvalCommand(app, action);
  AddTrainVocabularyCommand(app, action);
}

int RunAction(const Action& action, const Console& console) {
  const absl::Status status = action(console);
  console.out.flush();
  if (!status.ok()) {
    console.err << "semmap: " << Explain(status) << "\n";
  } else if (!console.out) {
    console.err << "semmap: standard output cannot be written\n";
    return kExitFailed;
  }
  return ExitCodeOf(status);
}

}  // namespace

int RunCommandLine(std::vector<std::string> arguments, const Console& console) {
  CLI::App app("semmap: drive recordings through a map server, look at maps, evaluate trajectories",
               "semmap");
  Action action;
  AddCommands(app, &action);
  int town_exit_code = kExitOk;
  AddTownCommand(app, &action, &town_exit_code);
  // CLI11 takes them last first.
  std::reverse(arguments.begin(), arguments.end());
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    return app.exit(error, console.out, console.err) == 0 ? kExitOk : kExitUsage;
  }
  // The town's commands did their work while the line was parsed.
  return action ? RunAction(action, console) : town_exit_code;
}

}  // namespace semmap::client
