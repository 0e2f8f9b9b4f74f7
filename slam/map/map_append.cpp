// The part of Map that takes another map in.
#include <algorithm>

#include "slam/map/map.h"

namespace semmap {
namespace {

template <typename Things>
auto Ascending(const Things& things) {
  std::vector<typename Things::key_type> ids;
  ids.reserve(things.size());
  for (const auto& [id, thing] : things) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace

void Map::Append(const Map& piece, const KeyFrameIdMap& new_ids) {
  const auto id_of = [&](KeyFrameId id) { return id.IsValid() ? new_ids.at(id) : id; };
  for (const KeyFrameId id : Ascending(piece.keyframes_)) {
    KeyFrame keyframe = piece.keyframes_.at(id);
    keyframe.id = id_of(id);
    keyframe.parent = id_of(keyframe.parent);
    for (KeyFrameId& loop : keyframe.loops) loop = id_of(loop);
    keyframe.points.assign(keyframe.points.size(), MapPointId());
    keyframe.covisible.clear();
    AddKeyFrame(std::move(keyframe));
  }
  for (const MapPointId id : Ascending(piece.points_)) {
    const MapPoint& from = piece.points_.at(id);
    MapPoint& point = points_.at(AddPoint(from.position_in_map, id_of(from.reference_keyframe)));
    for (const Observation& seen : from.observations)
      Attach(&point, &keyframe(id_of(seen.keyframe)), seen.keypoint);
    point.votes = from.votes;
    point.descriptor = from.descriptor;
    point.normal = from.normal;
    point.min_distance = from.min_distance;
    point.max_distance = from.max_distance;
    point.visible = from.visible;
    point.found = from.found;
    Reclassify(&point);
  }
}

void Map::Drop(const std::vector<KeyFrameId>& ids) {
  for (const KeyFrameId id : ids) {
    const std::vector<MapPointId> seen = keyframe(id).points;
    for (const MapPointId point : seen) {
      if (point.IsValid()) RemovePoint(point);
    }
  }
  for (const KeyFrameId id : ids) {
    keyframes_.erase(id);
    added_keyframes_.erase(id);
    moved_keyframes_.erase(id);
    rescaled_keyframes_.erase(id);
    reobserved_keyframes_.erase(id);
  }
  newest_keyframe_ = KeyFrameId();
  for (const auto& [id, keyframe] : keyframes_) newest_keyframe_ = std::max(newest_keyframe_, id);
}

double Map::RescaledBy(KeyFrameId id) const {
  const auto found = rescaled_keyframes_.find(id);
  return found == rescaled_keyframes_.end() ? 1.0 : found->second;
}

}  // namespace semmap
