#include "client/request_id.h"

#include <random>

namespace semmap::client {

std::string NewRequestId() {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::random_device source;
  std::uniform_int_distribution<int> digit(0, 15);
  std::string id;
  for (int i = 0; i < 32; ++i) id.push_back(kDigits[digit(source)]);
  return id;
}

}  // namespace semmap::client
