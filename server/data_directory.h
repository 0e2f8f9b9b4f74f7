#pragma once

#include <string>

#include "absl/status/status.h"
#include "storage/storage_config.h"

namespace semmap::server {

// Creates the directory and puts a relative SQLite database of the configuration there. FAILED_PRECONDITION
// when the directory cannot be made.
absl::Status UseDataDirectory(const std::string& directory, storage::StorageConfig* config);

}  // namespace semmap::server
