#include "slam/pipeline/map_pruner.h"

#include <algorithm>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "slam/pipeline/culling.h"

namespace semmap {
namespace {

// What a keyframe keeps while others have more than that: twice what relocalization wants.
constexpr int kKeptPoints = 100;
constexpr size_t kStepsPerVisit = 256;

// How well others see what the keyframe sees, [0, 1].
double Redundancy(const KeyFrame& keyframe, double close_depth, const Map& map) {
  int points = 0;
  int observers = 0;
  for (size_t i = 0; i < keyframe.points.size(); ++i) {
    const MapPoint* point = map.FindActivePoint(keyframe.points[i]);
    if (point == nullptr) continue;
    const Keypoint& keypoint = keyframe.features->keypoints[i];
    if (close_depth > 0 && (!keypoint.HasDepth() || keypoint.depth > close_depth)) continue;
    ++points;
    observers += CountOtherObservers(*point, keyframe.id, keypoint.octave, map);
  }
  // Without any point the keyframe is of no use.
  return points == 0 ? 1 : static_cast<double>(observers) / (kEnoughObservers * points);
}

absl::Status PruneKeyFrames(size_t limit, double close_depth, Map* map, const StepVisitor& visit) {
  // The most redundant first, of equal ones the older.
  using Ranked = std::pair<double, KeyFrameId>;
  const auto later = [](const Ranked& a, const Ranked& b) {
    return a.first != b.first ? a.first < b.first : a.second > b.second;
  };
  std::priority_queue<Ranked, std::vector<Ranked>, decltype(later)> ranked(later);
  for (const auto& [id, keyframe] : map->keyframes()) {
    if (keyframe.parent.IsValid()) ranked.emplace(Redundancy(keyframe, close_depth, *map), id);
  }
  const size_t excess = map->keyframes().size() - limit;
  for (size_t removed = 0, steps = 0; removed < excess && !ranked.empty(); ++steps) {
    if (steps % kStepsPerVisit == 0 && visit &&
        !visit(static_cast<double>(removed) / static_cast<double>(excess)))
      return absl::CancelledError("the pruning was cancelled");
    const auto [rank, id] = ranked.top();
    ranked.pop();
    // Removals make neighbours less redundant: whoever still is what it was is the most redundant.
    const double now = Redundancy(*map->FindKeyFrame(id), close_depth, *map);
    if (now < rank) {
      ranked.emplace(now, id);
      continue;
    }
    map->RemoveKeyFrame(id);
    ++removed;
  }
  return absl::OkStatus();
}

// Points, the weakest first.
std::vector<MapPointId> WeakestFirst(const Map& map) {
  std::vector<std::tuple<bool, size_t, float, MapPointId>> ranked;
  ranked.reserve(map.points().size());
  for (const auto& [id, point] : map.points()) {
    const float confidence = point.votes.ShareOf(point.semantic_class);
    ranked.emplace_back(point.active, point.observations.size(), confidence, id);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<MapPointId> ids;
  ids.reserve(ranked.size());
  for (const auto& entry : ranked) ids.push_back(std::get<MapPointId>(entry));
  return ids;
}

void PrunePoints(size_t limit, Map* map) {
  std::unordered_map<KeyFrameId, int, IdHash> left;  // active points of each keyframe
  for (const auto& [id, keyframe] : map->keyframes()) left[id] = map->CountPoints(id, 1);
  const auto is_spared = [&](const MapPoint& point) {
    return point.active &&
           std::any_of(point.observations.begin(), point.observations.end(),
                       [&](const Observation& seen) { return left[seen.keyframe] <= kKeptPoints; });
  };
  const std::vector<MapPointId> ranked = WeakestFirst(*map);
  for (const bool spares : {true, false}) {
    for (const MapPointId id : ranked) {
      if (map->points().size() <= limit) return;
      const MapPoint* point = map->FindPoint(id);
      if (point == nullptr || (spares && is_spared(*point))) continue;
      if (point->active) {
        for (const Observation& seen : point->observations) --left[seen.keyframe];
      }
      map->RemovePoint(id);
    }
  }
}

}  // namespace

absl::StatusOr<PruneResult> PruneToBudget(const PruneBudget& budget, const MappingCamera& camera, Map* map,
                                          const StepVisitor& visit) {
  const size_t keyframes = map->keyframes().size();
  const size_t points = map->points().size();
  if (budget.max_keyframes > 0 && keyframes > budget.max_keyframes) {
    const absl::Status status = PruneKeyFrames(budget.max_keyframes, camera.near_depth, map, visit);
    if (!status.ok()) return status;
  }
  if (budget.max_points > 0 && map->points().size() > budget.max_points) PrunePoints(budget.max_points, map);
  // Their descriptors and viewing directions are those of the observations that are left.
  std::vector<MapPointId> left;
  for (const auto& [id, point] : map->points()) left.push_back(id);
  if (map->keyframes().size() < keyframes) {
    for (const MapPointId id : left) map->UpdateAppearance(id);
  }
  return PruneResult{keyframes - map->keyframes().size(), points - map->points().size()};
}

}  // namespace semmap
