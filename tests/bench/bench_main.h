#pragma once

#include <iostream>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"

namespace semmap::bench {

// The common end of every benchmark's main: reads the command line into what the app's options point at, then
// calls `run`, which answers an absl::Status. Returns the exit code: 2 for a command line that is wrong, 1
// for a failure, which is printed behind the program's name.
template <typename Run>
int RunMain(CLI::App& app, const char* name, int argc, char** argv, const Run& run) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const absl::Status status = run();
  if (status.ok()) return 0;
  std::cerr << name << ": " << status << "\n";
  return 1;
}

}  // namespace semmap::bench
