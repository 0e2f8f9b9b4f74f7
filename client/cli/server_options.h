#pragma once

#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "client/connection.h"

namespace semmap::client {

// Where the server is and how to speak to it; the options that all online commands share.
struct ServerOptions {
  std::string address = "localhost:50051";
  std::string tls_ca;  // file names
  std::string tls_cert;
  std::string tls_key;
  std::string token_file;
  double timeout_s = 30;
};

void AddServerOptions(CLI::App& command, ServerOptions* options);

// Reads the files and connects. NOT_FOUND for a file that cannot be read, else Connection::Open's status.
absl::StatusOr<std::shared_ptr<Connection>> Connect(const ServerOptions& options);

}  // namespace semmap::client
