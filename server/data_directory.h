#pragma once

#include <string>

#include "absl/status/status.h"
#include "server/server_config.h"

namespace semmap::server {

// Creates the directory and puts a relative SQLite database and directory of artifacts there.
// FAILED_PRECONDITION when the directory cannot be made.
absl::Status UseDataDirectory(const std::string& directory, Config* config);

}  // namespace semmap::server
