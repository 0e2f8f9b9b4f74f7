#pragma once

#include <algorithm>
#include <vector>

#include "slam/pipeline/place_memory.h"
#include "tests/support/ring_world.h"
#include "tests/unit/place/place_test_util.h"

namespace semmap::testing {

inline std::vector<KeyFrameId> SortedKeyFrames(const Map& map) {
  std::vector<KeyFrameId> ids;
  for (const auto& [id, keyframe] : map.keyframes()) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

inline PlaceMemory Remember(const Map& map) {
  PlaceMemory places(RandomVocabulary(12, 5), PlaceQueryLimits());
  for (const KeyFrameId id : SortedKeyFrames(map)) places.Add(*map.FindKeyFrame(id));
  return places;
}

// 48 keyframes a lap, a little more than one lap.
constexpr double kRingStep = 2 * 3.14159265358979 / 48;
constexpr int kRingKeyFrames = 52;

}  // namespace semmap::testing
