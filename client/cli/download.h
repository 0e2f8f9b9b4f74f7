#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/client.h"

namespace semmap::client {

// Fetches what an export wrote to `path`; a download that breaks is taken up where it broke. The file appears
// under its name when it is whole and its checksum is right. DATA_LOSS when it is not, UNAVAILABLE when the
// file cannot be written, and what ReadArtifact says.
absl::Status Download(Client& client, const v1::ExportMapResponse& artifact, const std::string& path);

}  // namespace semmap::client
