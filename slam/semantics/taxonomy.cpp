#include "slam/semantics/taxonomy.h"

#include "absl/strings/match.h"

namespace semmap {

std::optional<uint8_t> FindSemanticClass(std::string_view name) {
  for (size_t id = 0; id < kSemanticClasses.size(); ++id) {
    const std::string_view known = kSemanticClasses[id].name;
    if (absl::EqualsIgnoreCase({name.data(), name.size()}, {known.data(), known.size()}))
      return static_cast<uint8_t>(id);
  }
  return std::nullopt;
}

}  // namespace semmap
