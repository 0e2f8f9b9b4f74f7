#pragma once

#include <cstdint>
#include <string>

#include "slam/common/fwd.h"

namespace semmap {

// Bounds on the work of one query, so that it does not grow with the map.
struct PlaceQueryLimits {
  // Entries of the inverted index that are read; the words that say most for each entry come first.
  int64_t max_postings = 200000;
  // Keyframes whose similarity is computed in full; at least the number asked for.
  int max_candidates = 64;

  void Read(ConfigReader& reader);
};

struct PlaceConfig {
  std::string vocabulary;  // path; empty: DefaultVocabularyPath()
  PlaceQueryLimits query;

  void Read(ConfigReader& reader);
};

}  // namespace semmap
