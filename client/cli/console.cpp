#include "client/cli/console.h"

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "client/errors.h"

namespace semmap::client {
namespace {

constexpr char kUsagePayload[] = "semmap.cli/usage";

}  // namespace

absl::Status UsageError(absl::string_view message) {
  absl::Status status = absl::InvalidArgumentError(message);
  status.SetPayload(kUsagePayload, absl::Cord("1"));
  return status;
}

int ExitCodeOf(const absl::Status& status) {
  if (status.ok()) return kExitOk;
  return status.GetPayload(kUsagePayload) ? kExitUsage : kExitFailed;
}

std::string Explain(const absl::Status& status) {
  const std::string reason = ErrorReason(status);
  return reason.empty() ? std::string(status.message()) : absl::StrCat(status.message(), " (", reason, ")");
}

}  // namespace semmap::client
