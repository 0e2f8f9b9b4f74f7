#include "slam/pipeline/loop_detector.h"

#include <algorithm>

namespace semmap {
namespace {

// Neighbours that share fewer points may look at something else.
constexpr int kMinSharedForScore = 30;
constexpr size_t kScoredNeighbours = 10;

// How little a keyframe may look like `current` and still show the same place: as little as its neighbours
// do.
double LowestNeighbourScore(const Map& map, const PlaceMemory& places, KeyFrameId current) {
  const BagOfWords& words = *places.WordsOf(current);
  double lowest = 1;
  for (const CovisibleKeyFrame& neighbour :
       map.BestCovisible(current, kScoredNeighbours, kMinSharedForScore)) {
    const BagOfWords* theirs = places.WordsOf(neighbour.id);
    if (theirs != nullptr) lowest = std::min(lowest, Similarity(words, *theirs));
  }
  return lowest;
}

// The keyframe, what it shares points with, and what those do.
std::unordered_set<KeyFrameId, IdHash> Surroundings(const Map& map, KeyFrameId id) {
  std::unordered_set<KeyFrameId, IdHash> around = {id};
  const KeyFrame& keyframe = *map.FindKeyFrame(id);
  for (const auto& [neighbour, shared] : keyframe.covisible) {
    around.insert(neighbour);
    for (const auto& [second, second_shared] : map.FindKeyFrame(neighbour)->covisible) around.insert(second);
  }
  return around;
}

template <typename Group>
bool Intersect(const Group& a, const Group& b) {
  return std::any_of(a.begin(), a.end(), [&](KeyFrameId id) { return b.contains(id); });
}

}  // namespace

std::vector<PlaceMatch> LoopDetector::FindSimilar(const Map& map, const PlaceMemory& places,
                                                  KeyFrameId current) const {
  const auto around = Surroundings(map, current);
  const double min_score = config_.min_score_share * LowestNeighbourScore(map, places, current);
  return places.index().Query(*places.WordsOf(current), static_cast<size_t>(config_.candidates), min_score,
                              [&](KeyFrameId id) { return around.contains(id); });
}

std::vector<KeyFrameId> LoopDetector::Detect(const Map& map, const PlaceMemory& places, KeyFrameId current) {
  std::vector<KeyFrameId> confirmed;
  std::vector<Chain> continued;
  for (const PlaceMatch& match : FindSimilar(map, places, current)) {
    Chain chain{{match.keyframe}, 1};
    for (const auto& [neighbour, shared] : map.FindKeyFrame(match.keyframe)->covisible)
      chain.group.insert(neighbour);
    for (const Chain& before : chains_) {
      if (Intersect(before.group, chain.group)) chain.length = std::max(chain.length, before.length + 1);
    }
    if (chain.length >= config_.consistency) confirmed.push_back(match.keyframe);
    continued.push_back(std::move(chain));
  }
  chains_ = std::move(continued);
  return confirmed;
}

}  // namespace semmap
