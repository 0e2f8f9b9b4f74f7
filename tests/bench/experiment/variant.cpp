#include "tests/bench/experiment/variant.h"

namespace semmap::bench {
namespace {

std::vector<Variant> MakeVariants() {
  std::vector<Variant> variants = {{"base", "no semantics", MaskSource::kNone}};
  const auto add = [&](const std::string& name, const std::string& description, bool votes, bool filter,
                       bool penalty, bool strict) {
    const std::string perfect = name == "paper" ? "perfect" : "perfect-" + name;
    variants.push_back({name, description, MaskSource::kModel, votes, filter, penalty, strict});
    variants.push_back(
        {perfect, description + ", true masks", MaskSource::kTruth, votes, filter, penalty, strict});
  };
  add("paper", "all parts", true, true, true, false);
  add("semmap", "all parts, and corners on the rim of the sky are no sky", true, true, true, false);
  variants[variants.size() - 2].rims = variants.back().rims = true;
  add("filter", "inactive points alone", true, true, false, false);
  add("penalty", "association alone", true, false, true, false);
  add("first", "first label instead of votes", false, true, true, false);
  add("strict", "no matches across classes", true, true, true, true);
  return variants;
}

}  // namespace

SlamConfig Variant::Configure(SlamConfig base) const {
  base.deterministic = true;
  base.semantics.enabled = masks != MaskSource::kNone;
  base.semantics.votes = votes;
  base.semantics.filter_inactive = filter;
  if (!rims) base.semantics.sky_rim_px = base.semantics.class_rim_px = 0;
  if (!penalty) base.semantics.penalty = 0;
  base.semantics.strict = strict;
  return base;
}

const std::vector<Variant>& AllVariants() {
  static const std::vector<Variant> variants = MakeVariants();
  return variants;
}

const Variant* FindVariant(const std::string& name) {
  for (const Variant& variant : AllVariants()) {
    if (variant.name == name) return &variant;
  }
  return nullptr;
}

}  // namespace semmap::bench
