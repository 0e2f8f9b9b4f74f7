#include "slam/map/local_map_view.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "slam/common/status_macros.h"

namespace semmap {
namespace {

constexpr size_t kExpandedNeighbours = 10;

absl::StatusOr<std::vector<KeyFrameId>> CollectKeyFrames(KeyFrameId center, const LocalMapViewLimits& limits,
                                                         LocalMapSource* source) {
  std::vector<KeyFrameId> chosen = {center};
  if (limits.neighbours == 0) return chosen;
  std::unordered_set<KeyFrameId, IdHash> seen = {center};
  const auto add = [&](KeyFrameId id) {
    if (seen.insert(id).second) chosen.push_back(id);
  };
  SEMMAP_ASSIGN_OR_RETURN(const auto neighbours, source->BestCovisible(center, limits.neighbours));
  for (const CovisibleKeyFrame& neighbour : neighbours) add(neighbour.id);
  for (size_t i = 0; i < std::min(neighbours.size(), kExpandedNeighbours); ++i) {
    SEMMAP_ASSIGN_OR_RETURN(const auto seconds,
                            source->BestCovisible(neighbours[i].id, limits.second_neighbours));
    for (const CovisibleKeyFrame& second : seconds) add(second.id);
  }
  return chosen;
}

ViewPoint ToViewPoint(const MapPoint& point) {
  return {point.id,
          point.position_in_map,
          point.normal,
          point.min_distance,
          point.max_distance,
          point.descriptor,
          static_cast<uint32_t>(point.observations.size()),
          point.semantic_class};
}

// A map in memory.
class MapAsSource : public LocalMapSource {
 public:
  explicit MapAsSource(const Map& map) : map_(map) {}

  absl::StatusOr<std::vector<CovisibleKeyFrame>> BestCovisible(KeyFrameId id, size_t limit) override {
    return map_.BestCovisible(id, limit);
  }
  absl::Status AddPointsOf(KeyFrameId id, size_t max_points, LocalMapView* view) override {
    for (const MapPointId point_id : map_.FindKeyFrame(id)->points) {
      if (!point_id.IsValid() || view->size() >= max_points || view->IndexOf(point_id) >= 0) continue;
      const MapPoint* point = map_.FindActivePoint(point_id);
      if (point != nullptr) view->Add(ToViewPoint(*point));
    }
    return absl::OkStatus();
  }
  absl::Status AddKeyFrame(KeyFrameId id, LocalMapView* view) override {
    const KeyFrame& keyframe = *map_.FindKeyFrame(id);
    view->Add({keyframe.id, keyframe.camera_from_map, keyframe.features, keyframe.grid, {}}, keyframe.points);
    return absl::OkStatus();
  }

 private:
  const Map& map_;
};

}  // namespace

void LocalMapView::Add(const ViewPoint& point) {
  index_of_id.emplace(point.id, static_cast<int32_t>(ids.size()));
  ids.push_back(point.id);
  positions.push_back(point.position_in_map);
  normals.push_back(point.normal);
  min_distances.push_back(point.min_distance);
  max_distances.push_back(point.max_distance);
  descriptors.push_back(point.descriptor);
  observation_counts.push_back(point.observation_count);
  classes.push_back(point.semantic_class);
}

void LocalMapView::Add(ViewKeyFrame keyframe, std::span<const MapPointId> points) {
  keyframe.point_of_keypoint.reserve(points.size());
  for (const MapPointId point : points) {
    keyframe.point_of_keypoint.push_back(point.IsValid() ? IndexOf(point) : -1);
  }
  keyframes.push_back(std::move(keyframe));
}

const ViewKeyFrame* LocalMapView::FindKeyFrame(KeyFrameId id) const {
  const auto found =
      std::find_if(keyframes.begin(), keyframes.end(), [&](const ViewKeyFrame& k) { return k.id == id; });
  return found == keyframes.end() ? nullptr : &*found;
}

absl::Status FillLocalMapView(KeyFrameId center, const LocalMapViewLimits& limits, LocalMapSource* source,
                              LocalMapView* view) {
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<KeyFrameId> chosen, CollectKeyFrames(center, limits, source));
  for (const KeyFrameId id : chosen) SEMMAP_RETURN_IF_ERROR(source->AddPointsOf(id, limits.max_points, view));
  for (size_t i = 0; i < std::min(chosen.size(), limits.keyframes); ++i)
    SEMMAP_RETURN_IF_ERROR(source->AddKeyFrame(chosen[i], view));
  return absl::OkStatus();
}

std::shared_ptr<const LocalMapView> MakeLocalMapView(const Map& map, KeyFrameId center, uint64_t version,
                                                     const LocalMapViewLimits& limits) {
  if (map.FindKeyFrame(center) == nullptr) return nullptr;
  auto view = std::make_shared<LocalMapView>();
  view->version = version;
  view->map_keyframes = static_cast<int>(map.keyframes().size());
  MapAsSource source(map);
  // A map in memory can always be read.
  FillLocalMapView(center, limits, &source, view.get()).IgnoreError();
  return view;
}

}  // namespace semmap
