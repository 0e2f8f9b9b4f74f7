#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"

namespace grpc {
class Channel;
}

namespace semmap::client {

// Certificates in PEM, as text (not file names).
struct TlsOptions {
  std::string root_certificates;  // empty: the system's
  // Both or none; for servers that ask for a client certificate.
  std::string client_certificate;
  std::string client_key;
  // Empty: the host of the address. For servers reached by another name than their certificate's.
  std::string server_name;
};

struct ConnectOptions {
  std::string address;            // HOST:PORT
  std::optional<TlsOptions> tls;  // none: plain text
  std::string token;              // sent as "authorization: Bearer TOKEN" with TLS; empty: none
  std::chrono::milliseconds connect_timeout{10'000};
  // For each unary call, and for the time between two messages that a call waits for.
  std::chrono::milliseconds call_timeout{30'000};
  std::chrono::milliseconds keepalive_interval{60'000};
  int64_t max_message_bytes = 64 << 20;
};

// A connection to one server, shared by everything that talks to it. gRPC mends it by itself when it breaks.
// Thread-safe.
class Connection {
 public:
  // UNAVAILABLE or DEADLINE_EXCEEDED when the server cannot be reached within connect_timeout.
  static absl::StatusOr<std::shared_ptr<Connection>> Open(ConnectOptions options);

  const ConnectOptions& options() const { return options_; }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

 private:
  Connection(ConnectOptions options, std::shared_ptr<grpc::Channel> channel);

  ConnectOptions options_;
  std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace semmap::client
