#include "slam/map/local_map_view.h"

#include <algorithm>
#include <unordered_set>

namespace semmap {
namespace {

// How many keyframes besides the reference bring their features along, for matching by descriptor alone.
constexpr size_t kKeyFramesWithFeatures = 6;
constexpr size_t kExpandedNeighbours = 10;

std::vector<KeyFrameId> CollectKeyFrames(const Map& map, KeyFrameId center,
                                         const LocalMapViewLimits& limits) {
  std::vector<KeyFrameId> chosen = {center};
  std::unordered_set<KeyFrameId, IdHash> seen = {center};
  const auto add = [&](KeyFrameId id) {
    if (seen.insert(id).second) chosen.push_back(id);
  };
  const auto neighbours = map.BestCovisible(center, limits.neighbours);
  for (const CovisibleKeyFrame& neighbour : neighbours) add(neighbour.id);
  for (size_t i = 0; i < std::min(neighbours.size(), kExpandedNeighbours); ++i) {
    for (const CovisibleKeyFrame& second : map.BestCovisible(neighbours[i].id, limits.second_neighbours))
      add(second.id);
  }
  return chosen;
}

void AddPoint(const MapPoint& point, LocalMapView* view) {
  view->index_of_id.emplace(point.id, static_cast<int32_t>(view->ids.size()));
  view->ids.push_back(point.id);
  view->positions.push_back(point.position_in_map);
  view->normals.push_back(point.normal);
  view->min_distances.push_back(point.min_distance);
  view->max_distances.push_back(point.max_distance);
  view->descriptors.push_back(point.descriptor);
  view->observation_counts.push_back(static_cast<uint32_t>(point.observations.size()));
  view->classes.push_back(point.semantic_class);
}

ViewKeyFrame ToViewKeyFrame(const KeyFrame& keyframe, const LocalMapView& view) {
  ViewKeyFrame result{keyframe.id, keyframe.camera_from_map, keyframe.features, keyframe.grid, {}};
  result.point_of_keypoint.reserve(keyframe.points.size());
  for (const MapPointId point : keyframe.points) {
    result.point_of_keypoint.push_back(point.IsValid() ? view.IndexOf(point) : -1);
  }
  return result;
}

}  // namespace

const ViewKeyFrame* LocalMapView::FindKeyFrame(KeyFrameId id) const {
  const auto found =
      std::find_if(keyframes.begin(), keyframes.end(), [&](const ViewKeyFrame& k) { return k.id == id; });
  return found == keyframes.end() ? nullptr : &*found;
}

std::shared_ptr<const LocalMapView> MakeLocalMapView(const Map& map, KeyFrameId center, uint64_t version,
                                                     const LocalMapViewLimits& limits) {
  if (map.FindKeyFrame(center) == nullptr) return nullptr;
  auto view = std::make_shared<LocalMapView>();
  view->version = version;
  view->map_keyframes = static_cast<int>(map.keyframes().size());
  const std::vector<KeyFrameId> chosen = CollectKeyFrames(map, center, limits);
  for (const KeyFrameId id : chosen) {
    for (const MapPointId point_id : map.FindKeyFrame(id)->points) {
      if (!point_id.IsValid() || view->size() >= limits.max_points || view->IndexOf(point_id) >= 0) continue;
      const MapPoint* point = map.FindActivePoint(point_id);
      if (point != nullptr) AddPoint(*point, view.get());
    }
  }
  for (size_t i = 0; i < std::min(chosen.size(), kKeyFramesWithFeatures + 1); ++i) {
    view->keyframes.push_back(ToViewKeyFrame(*map.FindKeyFrame(chosen[i]), *view));
  }
  return view;
}

}  // namespace semmap
