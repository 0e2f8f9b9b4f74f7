#pragma once

#include <string>
#include <string_view>

namespace semmap::client {

// "maps/town" of "town"; a name that has the prefix stays as it is.
std::string MapName(std::string_view id);
// "sessions/7f" of "7f"; a name that has the prefix stays as it is.
std::string SessionName(std::string_view id);
// "town" of "maps/town", "7f" of "sessions/7f".
std::string IdOfName(std::string_view name);

}  // namespace semmap::client
