#pragma once

#include <string>

namespace semmap::client {

// 32 random hexadecimal digits: tells a repeated request from a new one.
std::string NewRequestId();

}  // namespace semmap::client
