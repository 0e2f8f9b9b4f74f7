#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "client/cli/commands.h"

int main(int argc, char** argv) {
  const semmap::client::Console console{std::cout, std::cerr, isatty(STDERR_FILENO) != 0};
  return semmap::client::RunCommandLine(std::vector<std::string>(argv + 1, argv + argc), console);
}
