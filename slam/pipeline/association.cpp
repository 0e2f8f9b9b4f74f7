#include "slam/pipeline/association.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace semmap {
namespace {

constexpr int kRotationBins = 30;

int RotationBin(const Keypoint& first, const Keypoint& second) {
  constexpr float kTurn = 2 * std::numbers::pi_v<float>;
  float turn = (second.angle - first.angle) / kTurn;
  turn -= std::floor(turn);
  return static_cast<int>(turn * kRotationBins + 0.5F) % kRotationBins;
}

}  // namespace

void KeepConsistentRotation(const std::vector<Keypoint>& first, const std::vector<Keypoint>& second,
                            std::vector<KeypointPair>* pairs) {
  std::array<int, kRotationBins> counts{};
  for (const KeypointPair& pair : *pairs) ++counts[RotationBin(first[pair.first], second[pair.second])];
  const auto fullest = std::max_element(counts.begin(), counts.end());
  const int peak = static_cast<int>(fullest - counts.begin());
  // The peak may straddle a border, hence its two neighbours count with it.
  std::erase_if(*pairs, [&](const KeypointPair& pair) {
    const int offset = std::abs(RotationBin(first[pair.first], second[pair.second]) - peak);
    return std::min(offset, kRotationBins - offset) > 1;
  });
}

void KeepBestOfSecond(size_t second_count, std::vector<KeypointPair>* pairs) {
  std::vector<int> best(second_count, 257);
  for (const KeypointPair& pair : *pairs) best[pair.second] = std::min(best[pair.second], pair.distance);
  std::erase_if(*pairs, [&](const KeypointPair& pair) {
    if (pair.distance > best[pair.second]) return true;
    best[pair.second] = -1;  // of equally close ones the first stays
    return false;
  });
}

}  // namespace semmap
