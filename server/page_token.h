#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace semmap::server {

// Page tokens: opaque to clients, bound to the request that they continue. `scope` is what the request asked
// for besides page size and token.

std::string MakePageToken(const std::string& scope, const std::string& cursor);

// The cursor; empty for an empty token. PAGE_TOKEN_INVALID for anything that MakePageToken did not make for
// `scope`.
absl::StatusOr<std::string> ReadPageToken(const std::string& scope, const std::string& token);

// 0: `standard`; more than `maximum`: `maximum`; negative: FIELD_INVALID.
absl::StatusOr<int> ReadPageSize(int requested, int standard = 100, int maximum = 1000);

}  // namespace semmap::server
