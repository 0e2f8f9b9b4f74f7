// The town's commands on their own: `semmap_town town drive --route 2 --output DIR`.
#include <exception>

#include "CLI/CLI.hpp"
#include "client/town/commands.h"

int main(int argc, char** argv) {
  CLI::App app("The simulated town of semmap");
  app.require_subcommand(1);
  int exit_code = 0;
  semmap::town::AddTownCommands(&app, &exit_code);
  CLI11_PARSE(app, argc, argv);
  return exit_code;
}
