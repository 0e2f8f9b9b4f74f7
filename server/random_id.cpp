#include "server/random_id.h"

#include <random>

namespace semmap::server {

std::string RandomHex(size_t bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  // With libstdc++ on Linux this reads the kernel's generator.
  std::random_device source;
  std::uniform_int_distribution<int> digit(0, 15);
  std::string text;
  for (size_t i = 0; i < 2 * bytes; ++i) text.push_back(kDigits[digit(source)]);
  return text;
}

}  // namespace semmap::server
