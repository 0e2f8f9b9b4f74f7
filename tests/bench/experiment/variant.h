#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slam/pipeline/slam_config.h"

namespace semmap::bench {

enum class MaskSource { kNone, kModel, kTruth };

// One way to run the algorithm over a drive.
struct Variant {
  std::string name;
  std::string description;
  MaskSource masks = MaskSource::kModel;
  bool votes = true;
  bool filter = true;
  bool penalty = true;
  bool strict = false;
  bool rims = false;  // rules for corners on the rim of a class, beyond the paper

  // `base` with the switches set so; deterministic.
  SlamConfig Configure(SlamConfig base) const;
};

// All of them: the base algorithm; the paper's; semmap's own, which goes beyond it; each of the paper's parts
// alone; the strict variant that it rejects. Each but the base with a model's masks and ("perfect...") with
// true ones.
const std::vector<Variant>& AllVariants();
// Null for an unknown name.
const Variant* FindVariant(const std::string& name);

}  // namespace semmap::bench
