#pragma once

#include <ostream>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace semmap::client {

// Where a command speaks: results go to `out` (with --json nothing but the JSON), everything else to `err`.
struct Console {
  std::ostream& out;
  std::ostream& err;
  // A progress bar may overwrite its line.
  bool err_is_terminal = false;
};

constexpr int kExitOk = 0;
constexpr int kExitFailed = 1;
constexpr int kExitUsage = 2;

// A failure that lies in how the command was called, which exits with kExitUsage instead of kExitFailed.
absl::Status UsageError(absl::string_view message);
int ExitCodeOf(const absl::Status& status);

// For people: the message, with the reason of the service behind it if there is one.
std::string Explain(const absl::Status& status);

}  // namespace semmap::client
