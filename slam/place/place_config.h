#pragma once

#include <cstdint>
#include <string>

#include "slam/common/fwd.h"

namespace semmap {

// Bounds on the work of one query, so that it does not grow with the map. A query that stays within both
// is exact.
struct PlaceQueryLimits {
  // Entries of the inverted index that are read; the words that say most for each entry come first.
  int64_t max_postings = 400000;
  // Keyframes whose similarity is computed in full after some words had to be left out; at least the number
  // asked for.
  int max_candidates = 200;

  void Read(ConfigReader& reader);
};

struct PlaceConfig {
  std::string vocabulary;  // path; empty: DefaultVocabularyPath()
  PlaceQueryLimits query;

  void Read(ConfigReader& reader);
};

}  // namespace semmap
