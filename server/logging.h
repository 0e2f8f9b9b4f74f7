#pragma once

#include <string>

namespace semmap::server {

// Logs of the process go to standard error, one line each: time in UTC, level, what happened, and key=value
// pairs such as session= and map=. Standard output stays free for what programs read. `level`: trace, debug,
// info, warn or error.
void SetUpLogging(const std::string& level);

}  // namespace semmap::server
