#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace semmap::client {

// Name of a semantic class (CARLA's 23 ids, as in semantics.proto); "-" for 255, the number for others.
std::string ClassName(uint32_t id);

// Id of a class given by name (any case) or number.
std::optional<uint32_t> ParseClass(absl::string_view text);

}  // namespace semmap::client
