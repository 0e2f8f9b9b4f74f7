#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/connection.h"

namespace semmap::kill_test {

inline absl::StatusOr<std::shared_ptr<client::Connection>> Connect(const std::string& address) {
  client::ConnectOptions options;
  options.address = address;
  return client::Connection::Open(options);
}

}  // namespace semmap::kill_test
