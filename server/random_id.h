#pragma once

#include <string>

namespace semmap::server {

// `bytes` from the operating system's source of secrets, as lower-case hexadecimal digits: ids and tokens
// that nobody can guess.
std::string RandomHex(size_t bytes);

}  // namespace semmap::server
