#include "client/cli/server_options.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/cli/console.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

constexpr size_t kMaxSecretBytes = size_t{1} << 20;

absl::StatusOr<std::string> ReadSmallFile(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string text(kMaxSecretBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.gcount() == 0) return absl::NotFoundError(absl::StrCat(path, ": cannot be read, or is empty"));
  text.resize(static_cast<size_t>(stream.gcount()));
  if (text.size() > kMaxSecretBytes) return absl::InvalidArgumentError(absl::StrCat(path, ": is too large"));
  return text;
}

absl::StatusOr<TlsOptions> ReadTls(const ServerOptions& options) {
  TlsOptions tls;
  if (!options.tls_ca.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(tls.root_certificates, ReadSmallFile(options.tls_ca));
  }
  if (options.tls_cert.empty() != options.tls_key.empty()) {
    return UsageError("--tls-cert and --tls-key belong together");
  }
  if (!options.tls_cert.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(tls.client_certificate, ReadSmallFile(options.tls_cert));
    SEMMAP_ASSIGN_OR_RETURN(tls.client_key, ReadSmallFile(options.tls_key));
  }
  return tls;
}

}  // namespace

void AddServerOptions(CLI::App& command, ServerOptions* options) {
  command
      .add_option("--server", options->address, "HOST:PORT; default $SEMMAP_SERVER or " + options->address)
      ->envname("SEMMAP_SERVER");
  command.add_option("--tls-ca", options->tls_ca, "Speak TLS; certificates to trust (PEM)");
  command.add_option("--tls-cert", options->tls_cert, "Client certificate (PEM)");
  command.add_option("--tls-key", options->tls_key, "Its key (PEM)");
  command.add_option("--token-file", options->token_file, "File with the bearer token");
  command.add_option("--timeout", options->timeout_s, "Seconds that a call may take; default 30")
      ->check(CLI::Range(0.1, 86400.0));
}

absl::StatusOr<std::shared_ptr<Connection>> Connect(const ServerOptions& options) {
  ConnectOptions connect;
  connect.address = options.address;
  connect.call_timeout = std::chrono::milliseconds(static_cast<int64_t>(options.timeout_s * 1e3));
  connect.connect_timeout = std::min(connect.connect_timeout, connect.call_timeout);
  if (!options.tls_ca.empty() || !options.tls_cert.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(connect.tls, ReadTls(options));
  }
  if (!options.token_file.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(const std::string token, ReadSmallFile(options.token_file));
    connect.token = std::string(absl::StripAsciiWhitespace(token));
  }
  return Connection::Open(std::move(connect));
}

}  // namespace semmap::client
