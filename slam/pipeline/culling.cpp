#include "slam/pipeline/culling.h"

namespace semmap {
namespace {

constexpr uint64_t kProbationKeyFrames = 2;
constexpr double kMinFoundShare = 0.25;

enum class Verdict { kKeep, kPassed, kRemove };

Verdict Judge(const MapPoint& point, uint64_t age, size_t needed_observations) {
  if (point.found < kMinFoundShare * point.visible) return Verdict::kRemove;
  if (age >= kProbationKeyFrames && point.observations.size() < needed_observations) return Verdict::kRemove;
  return age > kProbationKeyFrames ? Verdict::kPassed : Verdict::kKeep;
}

bool IsKeyFrameRedundant(const KeyFrame& keyframe, double share, double close_depth_m, const Map& map) {
  int points = 0;
  int redundant = 0;
  for (size_t i = 0; i < keyframe.points.size(); ++i) {
    const MapPoint* point = map.FindActivePoint(keyframe.points[i]);
    if (point == nullptr) continue;
    const Keypoint& keypoint = keyframe.features->keypoints[i];
    if (close_depth_m > 0 && (!keypoint.HasDepth() || keypoint.depth > close_depth_m)) continue;
    ++points;
    if (point->observations.size() > kEnoughObservers &&
        CountOtherObservers(*point, keyframe.id, keypoint.octave, map) >= kEnoughObservers)
      ++redundant;
  }
  return redundant > share * points;
}

}  // namespace

void YoungPoints::Add(const std::vector<MapPointId>& created) {
  for (const MapPointId id : created) points_.push_back({id, keyframes_});
}

void YoungPoints::Cull(bool has_depth, Map* map) {
  const size_t needed = has_depth ? 2 : 3;
  std::erase_if(points_, [&](const Newborn& young) {
    const MapPoint* point = map->FindPoint(young.id);
    if (point == nullptr) return true;
    const Verdict verdict = Judge(*point, keyframes_ - young.born_at_keyframe, needed);
    if (verdict == Verdict::kRemove) map->RemovePoint(young.id);
    return verdict != Verdict::kKeep;
  });
}

int CountOtherObservers(const MapPoint& point, KeyFrameId self, int octave, const Map& map) {
  int observers = 0;
  for (const Observation& observation : point.observations) {
    if (observation.keyframe == self) continue;
    const KeyFrame& other = *map.FindKeyFrame(observation.keyframe);
    if (other.features->keypoints[observation.keypoint].octave <= octave + 1 &&
        ++observers >= kEnoughObservers)
      break;
  }
  return observers;
}

std::vector<KeyFrameId> CullKeyFrames(const MappingConfig& config, double close_depth_m, KeyFrameId keyframe,
                                      Map* map) {
  constexpr size_t kMaxChecked = 60;
  std::vector<KeyFrameId> removed;
  for (const CovisibleKeyFrame& neighbour : map->BestCovisible(keyframe, kMaxChecked)) {
    const KeyFrame* candidate = map->FindKeyFrame(neighbour.id);
    // The first keyframe carries the map's frame; the newest ones are what the tracker stands on.
    if (!candidate->parent.IsValid() || neighbour.id == map->newest_keyframe()) continue;
    if (!IsKeyFrameRedundant(*candidate, config.cull_redundancy, close_depth_m, *map)) continue;
    map->RemoveKeyFrame(neighbour.id);
    removed.push_back(neighbour.id);
  }
  return removed;
}

}  // namespace semmap
