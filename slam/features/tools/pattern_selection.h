#pragma once

#include <cstdint>
#include <vector>

#include "slam/features/orb_pattern.h"

namespace semmap {

// Smoothed intensities of oriented patches at the places that tests may compare. Patch i is seen twice: in an
// image and in a distorted copy of it.
struct PatchSamples {
  struct Place {
    int8_t x = 0;
    int8_t y = 0;
  };

  std::vector<Place> places;
  // By place, then patch.
  std::vector<std::vector<uint8_t>> original;
  std::vector<std::vector<uint8_t>> distorted;
};

struct PatternSelectionConfig {
  // Pairs of places drawn at random to choose from.
  int candidates = 200000;
  uint32_t seed = 1;
  // Weight of how often a bit differs between the two sights of one patch; 0: as in the ORB paper.
  double instability_weight = 1.5;
  // Greatest correlation of a chosen test with another, to begin with, and its step when too few are found.
  double first_correlation = 0.1;
  double correlation_step = 0.02;
};

struct PatternSelection {
  BriefPattern pattern;
  double max_correlation = 0;   // that had to be accepted
  double mean_instability = 0;  // share of bits that differ between the sights of a patch
};

// Greedy choice of tests (Rublee et al., ORB, ICCV 2011, section 4.3): ordered by how evenly they split the
// patches, each is taken unless it correlates with one taken before; the bound is raised until there are
// enough. Beyond the paper, tests that flip between two sights of a patch come later. Needs at least 64
// patches and places for 256 pairs.
PatternSelection SelectPattern(const PatchSamples& samples, const PatternSelectionConfig& config);

}  // namespace semmap
