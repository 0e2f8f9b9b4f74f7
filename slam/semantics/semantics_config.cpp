#include "slam/semantics/semantics_config.h"

#include "absl/strings/str_cat.h"
#include "slam/common/config_reader.h"

namespace semmap {

SemanticsConfig::SemanticsConfig() {
  for (const SemanticClass inactive : kInactiveClasses)
    inactive_classes.emplace_back(kSemanticClasses[static_cast<size_t>(inactive)].name);
}

ClassSet SemanticsConfig::InactiveClasses() const {
  ClassSet set;
  if (!enabled || !filter_inactive) return set;
  for (const std::string& name : inactive_classes) {
    if (const auto id = FindSemanticClass(name)) set.Add(*id);
  }
  return set;
}

void SemanticsConfig::Read(ConfigReader& reader) {
  reader.Flag("enabled", &enabled);
  reader.Number("min_confidence", &min_confidence, 0.0, 1.0);
  reader.Number("sky_rim_px", &sky_rim_px, 0.0, 20.0);
  reader.Number("class_rim_px", &class_rim_px, 0.0, 20.0);
  reader.Flag("votes", &votes);
  reader.Flag("filter_inactive", &filter_inactive);
  reader.TextList("inactive_classes", &inactive_classes, kSemanticClassCount);
  for (const std::string& name : inactive_classes) {
    if (!FindSemanticClass(name))
      reader.Complain("inactive_classes", absl::StrCat("has no class '", name, "'"));
  }
  reader.Number("penalty", &penalty, 0.0, 10.0);
  reader.Flag("strict", &strict);
}

}  // namespace semmap
