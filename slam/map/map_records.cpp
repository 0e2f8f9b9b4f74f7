// The part of Map that turns its notes of what changed into a MapDelta.
#include <algorithm>

#include "slam/map/map.h"

namespace semmap {
namespace {

template <typename Set>
auto Sorted(const Set& ids) {
  std::vector<typename Set::value_type> sorted(ids.begin(), ids.end());
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace

MapPointRecord Map::ToRecord(const MapPoint& point) const {
  MapPointRecord record;
  record.id = point.id;
  record.position_in_map = point.position_in_map;
  record.normal = point.normal;
  record.min_distance = point.min_distance;
  record.max_distance = point.max_distance;
  record.descriptor = point.descriptor;
  record.reference_keyframe = point.reference_keyframe;
  record.observation_count = static_cast<uint32_t>(point.observations.size());
  for (const Observation& observation : point.observations) {
    const KeyFrame& keyframe = keyframes_.at(observation.keyframe);
    const bool first = &observation == &point.observations.front();
    record.first_seen = first ? keyframe.timestamp : std::min(record.first_seen, keyframe.timestamp);
    record.last_seen = first ? keyframe.timestamp : std::max(record.last_seen, keyframe.timestamp);
  }
  record.semantic_class = point.semantic_class;
  record.class_confidence = point.votes.ShareOf(point.semantic_class);
  record.votes = point.votes.ToVector();
  return record;
}

MapDelta Map::TakeDelta() {
  MapDelta delta;
  delta.reset = std::exchange(was_reset_, false);
  for (const KeyFrameId id : Sorted(added_keyframes_)) {
    const KeyFrame& added = keyframes_.at(id);
    delta.added_keyframes.push_back(
        {id, added.sequence, added.timestamp, added.camera_from_map.Inverse(), added.parent, added.features});
    moved_keyframes_.erase(id);
    rescaled_keyframes_.erase(id);
  }
  for (const KeyFrameId id : Sorted(moved_keyframes_)) {
    const KeyFrame& moved = keyframes_.at(id);
    delta.moved_keyframes.push_back({id, moved.camera_from_map.Inverse(), moved.parent, RescaledBy(id)});
  }
  for (const MapPointId id : Sorted(changed_points_))
    delta.upserted_points.push_back(ToRecord(points_.at(id)));
  for (const KeyFrameId id : Sorted(reobserved_keyframes_)) {
    const KeyFrame& seeing = keyframes_.at(id);
    delta.observations.push_back({id, seeing.points, seeing.features});
  }
  std::swap(delta.removed_keyframes, removed_keyframes_);
  std::swap(delta.removed_points, removed_points_);
  added_keyframes_.clear();
  moved_keyframes_.clear();
  rescaled_keyframes_.clear();
  reobserved_keyframes_.clear();
  changed_points_.clear();
  new_points_.clear();
  return delta;
}

}  // namespace semmap
