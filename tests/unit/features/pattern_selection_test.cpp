#include "slam/features/tools/pattern_selection.h"

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace semmap {
namespace {

// Patches of independent noise at 64 places of two rows. The places of the second row differ between two
// sights of a patch, those of the first do not.
PatchSamples NoisePatches(int patches) {
  std::mt19937 random(5);
  PatchSamples samples;
  for (int i = 0; i < 64; ++i) {
    samples.places.push_back({static_cast<int8_t>(i % 32 - 16), static_cast<int8_t>(i / 32)});
    auto& original = samples.original.emplace_back(patches);
    for (uint8_t& value : original) value = static_cast<uint8_t>(random() % 256);
    auto& distorted = samples.distorted.emplace_back(original);
    if (i < 32) continue;
    for (uint8_t& value : distorted) value = static_cast<uint8_t>(random() % 256);
  }
  return samples;
}

int TestsOnStableRow(const BriefPattern& pattern) {
  return static_cast<int>(std::count_if(pattern.begin(), pattern.end(),
                                        [](const BriefTest& t) { return t.y1 == 0 && t.y2 == 0; }));
}

TEST(PatternSelection, TakesDistinctTestsAndPrefersStableOnes) {
  const PatchSamples samples = NoisePatches(640);
  PatternSelectionConfig config;
  config.candidates = 2016;        // all pairs
  config.first_correlation = 0.7;  // tests that share a place correlate by a third
  const PatternSelection selection = SelectPattern(samples, config);
  std::set<std::vector<int>> seen;
  for (const BriefTest& test : selection.pattern) seen.insert({test.x1, test.y1, test.x2, test.y2});
  EXPECT_EQ(seen.size(), 256u);
  EXPECT_EQ(TestsOnStableRow(selection.pattern), 256);
  EXPECT_EQ(selection.mean_instability, 0);

  config.instability_weight = 0;
  const PatternSelection careless = SelectPattern(samples, config);
  EXPECT_LT(TestsOnStableRow(careless.pattern), 128);
  EXPECT_GT(careless.mean_instability, 0.2);
}

TEST(PatternSelection, AvoidsCorrelatedTestsAsLongAsThereAreOthers) {
  PatchSamples samples = NoisePatches(640);
  samples.distorted = samples.original;
  // Every place of the second row shows what its neighbour in the first row shows: pairs of them are twins.
  for (int i = 32; i < 64; ++i) samples.original[i] = samples.distorted[i] = samples.original[i - 32];
  PatternSelectionConfig config;
  config.candidates = 2016;
  config.first_correlation = 0.6;
  const PatternSelection selection = SelectPattern(samples, config);
  EXPECT_LT(selection.max_correlation, 0.61);
  std::set<std::pair<int, int>> columns;
  for (const BriefTest& test : selection.pattern) columns.insert(std::minmax(int{test.x1}, int{test.x2}));
  EXPECT_EQ(columns.size(), 256u);
}

TEST(PatternSelection, IsDeterministic) {
  const PatchSamples samples = NoisePatches(128);
  PatternSelectionConfig config;
  config.candidates = 1500;
  EXPECT_EQ(SelectPattern(samples, config).pattern, SelectPattern(samples, config).pattern);
}

}  // namespace
}  // namespace semmap
