#include "client/connection.h"

#include <algorithm>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "absl/strings/str_cat.h"

namespace semmap::client {
namespace {

// Calls that change something carry a request id, so all unary calls may be repeated. The frame stream is
// taken up again by Drive, which knows what was answered.
constexpr char kServiceConfig[] = R"({
  "methodConfig": [
    {"name": [{"service": "semmap.v1.SessionService", "method": "StreamFrames"}]},
    {"name": [{"service": "semmap.v1.SessionService"}, {"service": "semmap.v1.MapService"}],
     "retryPolicy": {"maxAttempts": 4, "initialBackoff": "0.1s", "maxBackoff": "2s", "backoffMultiplier": 2,
                     "retryableStatusCodes": ["UNAVAILABLE"]}}
  ]
})";

std::shared_ptr<grpc::ChannelCredentials> MakeCredentials(const ConnectOptions& options) {
  if (!options.tls.has_value()) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions ssl;
  ssl.pem_root_certs = options.tls->root_certificates;
  ssl.pem_cert_chain = options.tls->client_certificate;
  ssl.pem_private_key = options.tls->client_key;
  auto credentials = grpc::SslCredentials(ssl);
  if (options.token.empty()) return credentials;
  return grpc::CompositeChannelCredentials(credentials, grpc::AccessTokenCredentials(options.token));
}

grpc::ChannelArguments MakeArguments(const ConnectOptions& options) {
  constexpr int kMaxReconnectMs = 2000;
  grpc::ChannelArguments arguments;
  const auto keepalive_ms = static_cast<int>(options.keepalive_interval.count());
  const auto max_bytes = static_cast<int>(std::clamp<int64_t>(options.max_message_bytes, 1, INT32_MAX));
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, keepalive_ms);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, keepalive_ms / 3);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kMaxReconnectMs);
  arguments.SetMaxReceiveMessageSize(max_bytes);
  arguments.SetMaxSendMessageSize(max_bytes);
  arguments.SetServiceConfigJSON(kServiceConfig);
  // Connections of one process that go to one server stay apart: a drive does not share its window with
  // others.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  if (options.tls.has_value() && !options.tls->server_name.empty()) {
    arguments.SetSslTargetNameOverride(options.tls->server_name);
  }
  return arguments;
}

}  // namespace

Connection::Connection(ConnectOptions options, std::shared_ptr<grpc::Channel> channel)
    : options_(std::move(options)), channel_(std::move(channel)) {}

absl::StatusOr<std::shared_ptr<Connection>> Connection::Open(ConnectOptions options) {
  if (options.address.empty()) return absl::InvalidArgumentError("no server address");
  if (!options.token.empty() && !options.tls.has_value()) {
    return absl::InvalidArgumentError("a token is only sent over TLS");
  }
  auto channel = grpc::CreateCustomChannel(options.address, MakeCredentials(options), MakeArguments(options));
  if (!channel->WaitForConnected(std::chrono::system_clock::now() + options.connect_timeout)) {
    return absl::UnavailableError(absl::StrCat("no server answers at ", options.address));
  }
  return std::shared_ptr<Connection>(new Connection(std::move(options), std::move(channel)));
}

}  // namespace semmap::client
