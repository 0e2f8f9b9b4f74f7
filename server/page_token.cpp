#include "server/page_token.h"

#include <algorithm>
#include <cstdint>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/error_reasons.h"

namespace semmap::server {
namespace {

constexpr size_t kHashDigits = 16;

// FNV-1a: tells tokens of different requests apart; it is no secret and need not be one.
uint64_t Hash(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

std::string Mark(const std::string& scope, const std::string& cursor) {
  // The length keeps (ab, c) apart from (a, bc).
  const uint64_t hash = Hash(absl::StrCat(scope.size(), ":", scope, cursor));
  return absl::StrCat(absl::Hex(hash, absl::kZeroPad16));
}

}  // namespace

std::string MakePageToken(const std::string& scope, const std::string& cursor) {
  return absl::WebSafeBase64Escape(Mark(scope, cursor) + cursor);
}

absl::StatusOr<std::string> ReadPageToken(const std::string& scope, const std::string& token) {
  if (token.empty()) return std::string();
  std::string text;
  const bool decoded = absl::WebSafeBase64Unescape(token, &text) && text.size() >= kHashDigits;
  const std::string cursor = decoded ? text.substr(kHashDigits) : std::string();
  if (decoded && text.substr(0, kHashDigits) == Mark(scope, cursor)) return cursor;
  return Error(v1::ERROR_REASON_PAGE_TOKEN_INVALID, "page_token is not one of this server for this request",
               {{"field", "page_token"}});
}

absl::StatusOr<int> ReadPageSize(int requested, int standard, int maximum) {
  if (requested < 0) return FieldInvalid("page_size", "must not be negative");
  return requested == 0 ? standard : std::min(requested, maximum);
}

}  // namespace semmap::server
