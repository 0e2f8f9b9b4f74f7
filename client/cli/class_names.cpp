#include "client/cli/class_names.h"

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "slam/semantics/taxonomy.h"

namespace semmap::client {

std::string ClassName(uint32_t id) {
  if (id == kUnknownClass) return "-";
  return id < kSemanticClasses.size() ? std::string(kSemanticClasses[id].name) : absl::StrCat(id);
}

std::optional<uint32_t> ParseClass(absl::string_view text) {
  if (const auto named = FindSemanticClass({text.data(), text.size()})) return *named;
  uint32_t id = 0;
  if (!absl::SimpleAtoi(text, &id) || id > kUnknownClass) return std::nullopt;
  return id;
}

}  // namespace semmap::client
