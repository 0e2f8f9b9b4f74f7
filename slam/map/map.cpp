#include "slam/map/map.h"

#include <algorithm>
#include <array>
#include <utility>

namespace semmap {
namespace {

// More keyframes than the tracker can be behind the mapper.
constexpr size_t kMaxHeirs = 1000;

// A class without any confidence is the point's own, handed to the keypoint: no news.
uint8_t VoteOf(const Keypoint& keypoint) {
  return keypoint.class_confidence > 0 ? keypoint.semantic_class : kUnknownClass;
}

}  // namespace

const KeyFrame* Map::FindKeyFrame(KeyFrameId id) const {
  const auto found = keyframes_.find(id);
  return found == keyframes_.end() ? nullptr : &found->second;
}

const MapPoint* Map::FindPoint(MapPointId id) const {
  const auto found = points_.find(id);
  return found == points_.end() ? nullptr : &found->second;
}

const MapPoint* Map::FindActivePoint(MapPointId id) const {
  const MapPoint* point = id.IsValid() ? FindPoint(id) : nullptr;
  return point != nullptr && point->active ? point : nullptr;
}

std::vector<CovisibleKeyFrame> Map::BestCovisible(KeyFrameId id, size_t limit, int min_shared) const {
  std::vector<CovisibleKeyFrame> neighbours;
  const KeyFrame* keyframe = FindKeyFrame(id);
  if (keyframe == nullptr) return neighbours;
  for (const auto& [other, shared] : keyframe->covisible) {
    if (shared >= min_shared) neighbours.push_back({other, shared});
  }
  std::sort(neighbours.begin(), neighbours.end(), [](const CovisibleKeyFrame& a, const CovisibleKeyFrame& b) {
    return a.shared_points != b.shared_points ? a.shared_points > b.shared_points : a.id > b.id;
  });
  if (neighbours.size() > limit) neighbours.resize(limit);
  return neighbours;
}

int Map::CountPoints(KeyFrameId id, int min_observations) const {
  const KeyFrame* keyframe = FindKeyFrame(id);
  if (keyframe == nullptr) return 0;
  return static_cast<int>(
      std::count_if(keyframe->points.begin(), keyframe->points.end(), [&](MapPointId point_id) {
        const MapPoint* point = point_id.IsValid() ? FindActivePoint(point_id) : nullptr;
        return point != nullptr && static_cast<int>(point->observations.size()) >= min_observations;
      }));
}

void Map::AddKeyFrame(KeyFrame keyframe) {
  const KeyFrameId id = keyframe.id;
  if (!first_keyframe_.IsValid()) first_keyframe_ = id;
  newest_keyframe_ = id;
  keyframes_.emplace(id, std::move(keyframe));
  added_keyframes_.insert(id);
  reobserved_keyframes_.insert(id);
}

MapPointId Map::AddPoint(const Eigen::Vector3d& position_in_map, KeyFrameId reference) {
  MapPoint point;
  point.id = MapPointId(next_point_id_++);
  point.position_in_map = position_in_map;
  point.reference_keyframe = reference;
  new_points_.insert(point.id);
  changed_points_.insert(point.id);
  const MapPointId id = point.id;
  points_.emplace(id, std::move(point));
  return id;
}

void Map::ChangeShared(KeyFrame* own, KeyFrame* other, int change) {
  const int shared = (own->covisible[other->id] += change);
  other->covisible[own->id] = shared;
  if (shared > 0) return;
  own->covisible.erase(other->id);
  other->covisible.erase(own->id);
}

void Map::CountShared(const MapPoint& point, KeyFrameId observer, int change) {
  if (!point.active) return;
  KeyFrame& own = keyframe(observer);
  for (const Observation& observation : point.observations) {
    if (observation.keyframe != observer) ChangeShared(&own, &keyframe(observation.keyframe), change);
  }
}

void Map::SetActive(MapPoint* point, bool active) {
  if (point->active == active) return;
  point->active = active;
  const std::vector<Observation>& observations = point->observations;
  for (size_t i = 0; i < observations.size(); ++i) {
    KeyFrame& own = keyframe(observations[i].keyframe);
    for (size_t j = i + 1; j < observations.size(); ++j)
      ChangeShared(&own, &keyframe(observations[j].keyframe), active ? +1 : -1);
  }
}

void Map::Reclassify(MapPoint* point) {
  point->semantic_class = classes_.ClassOf(point->votes);
  SetActive(point, classes_.IsActive(point->semantic_class));
}

bool Map::Attach(MapPoint* point, KeyFrame* observer, uint32_t keypoint) {
  MapPointId& slot = observer->points.at(keypoint);
  if (slot.IsValid()) return false;
  for (const Observation& observation : point->observations) {
    if (observation.keyframe == observer->id) return false;
  }
  slot = point->id;
  point->observations.push_back({observer->id, keypoint});
  CountShared(*point, observer->id, +1);
  reobserved_keyframes_.insert(observer->id);
  changed_points_.insert(point->id);
  return true;
}

bool Map::AddObservation(MapPointId point_id, KeyFrameId keyframe_id, uint32_t keypoint) {
  const auto point = points_.find(point_id);
  const auto observer = keyframes_.find(keyframe_id);
  if (point == points_.end() || observer == keyframes_.end()) return false;
  if (!Attach(&point->second, &observer->second, keypoint)) return false;
  point->second.votes.Add(VoteOf(observer->second.features->keypoints[keypoint]));
  Reclassify(&point->second);
  return true;
}

void Map::RemoveObservation(MapPointId point, KeyFrameId keyframe) { Detach(point, keyframe, true); }

void Map::Detach(MapPointId point_id, KeyFrameId keyframe_id, bool take_vote_back) {
  const auto found = points_.find(point_id);
  if (found == points_.end()) return;
  MapPoint& point = found->second;
  const auto observation = std::find_if(point.observations.begin(), point.observations.end(),
                                        [&](const Observation& o) { return o.keyframe == keyframe_id; });
  if (observation == point.observations.end()) return;
  if (point.observations.size() <= 2) {
    RemovePoint(point_id);
    return;
  }
  CountShared(point, keyframe_id, -1);
  KeyFrame& observer = keyframe(keyframe_id);
  observer.points[observation->keypoint] = MapPointId();
  const uint8_t seen_as = VoteOf(observer.features->keypoints[observation->keypoint]);
  point.observations.erase(observation);
  if (point.reference_keyframe == keyframe_id) point.reference_keyframe = point.observations.front().keyframe;
  if (take_vote_back) {
    point.votes.Remove(seen_as);
    Reclassify(&point);
  }
  reobserved_keyframes_.insert(keyframe_id);
  changed_points_.insert(point_id);
}

void Map::RemovePoint(MapPointId id) {
  const auto found = points_.find(id);
  if (found == points_.end()) return;
  MapPoint& point = found->second;
  while (!point.observations.empty()) {
    const Observation last = point.observations.back();
    CountShared(point, last.keyframe, -1);
    keyframe(last.keyframe).points[last.keypoint] = MapPointId();
    reobserved_keyframes_.insert(last.keyframe);
    point.observations.pop_back();
  }
  points_.erase(found);
  changed_points_.erase(id);
  if (new_points_.erase(id) == 0) removed_points_.push_back(id);
}

void Map::MergePoints(MapPointId kept, MapPointId dropped) {
  if (kept == dropped || FindPoint(kept) == nullptr) return;
  const auto found = points_.find(dropped);
  if (found == points_.end()) return;
  const std::vector<Observation> moving = found->second.observations;
  const ClassVotes votes = found->second.votes;
  const uint32_t visible = found->second.visible;
  const uint32_t times_found = found->second.found;
  RemovePoint(dropped);
  // Also where `kept` is seen by a keyframe already: both keypoints said what they are.
  MapPoint& point = points_.at(kept);
  for (const Observation& observation : moving)
    Attach(&point, &keyframe(observation.keyframe), observation.keypoint);
  point.votes.Add(votes);
  Reclassify(&point);
  AddSightings(kept, visible, times_found);
  UpdateAppearance(kept);
}

void Map::DetachFromTree(const KeyFrame& removed) {
  for (const auto& [other_id, shared] : removed.covisible) {
    KeyFrame& other = keyframe(other_id);
    if (other.parent != removed.id) continue;
    other.parent = removed.parent;
    moved_keyframes_.insert(other_id);
  }
  // A child may have lost every shared point since; the tree must not keep a dead parent.
  for (auto& [other_id, other] : keyframes_) {
    if (other.parent != removed.id) continue;
    other.parent = removed.parent;
    moved_keyframes_.insert(other_id);
  }
}

void Map::RemoveKeyFrame(KeyFrameId id) {
  const auto found = keyframes_.find(id);
  if (found == keyframes_.end() || id == first_keyframe_) return;
  KeyFrame& removed = found->second;
  DetachFromTree(removed);
  const KeyFrame& heir = keyframes_.at(removed.parent);
  RemovedKeyFrame record{id, heir.id, heir.camera_from_map * removed.camera_from_map.Inverse()};
  const std::vector<MapPointId> seen = removed.points;
  for (const MapPointId point : seen) {
    if (point.IsValid()) Detach(point, id, false);
  }
  for (const KeyFrameId other : removed.loops) std::erase(keyframe(other).loops, id);
  keyframes_.erase(found);
  moved_keyframes_.erase(id);
  rescaled_keyframes_.erase(id);
  reobserved_keyframes_.erase(id);
  heirs_[id] = record;
  removal_order_.push_back(id);
  if (removal_order_.size() > kMaxHeirs) {
    heirs_.erase(removal_order_.front());
    removal_order_.pop_front();
  }
  // A keyframe the sink never heard of needs no record there, except for frames that already refer to it.
  if (added_keyframes_.erase(id) == 0) removed_keyframes_.push_back(record);
}

void Map::SetPose(KeyFrameId id, const SE3& camera_from_map) {
  keyframe(id).camera_from_map = camera_from_map;
  moved_keyframes_.insert(id);
}

void Map::NoteRescaled(KeyFrameId id, double factor) {
  rescaled_keyframes_.try_emplace(id, 1.0).first->second *= factor;
  moved_keyframes_.insert(id);
}

void Map::AddLoop(KeyFrameId first, KeyFrameId second) {
  keyframe(first).loops.push_back(second);
  keyframe(second).loops.push_back(first);
}

void Map::SetPosition(MapPointId id, const Eigen::Vector3d& position_in_map) {
  points_.at(id).position_in_map = position_in_map;
  changed_points_.insert(id);
}

void Map::AddSightings(MapPointId id, uint32_t visible, uint32_t found) {
  const auto point = points_.find(id);
  if (point == points_.end()) return;
  point->second.visible += visible;
  point->second.found += found;
}

void Map::ChooseParent(KeyFrameId id) {
  KeyFrame& child = keyframe(id);
  if (id == first_keyframe_) return;
  child.parent = first_keyframe_;
  int most = 0;
  for (const auto& [other, shared] : child.covisible) {
    if (other >= id) continue;
    if (shared > most || (shared == most && other > child.parent)) {
      child.parent = other;
      most = shared;
    }
  }
  moved_keyframes_.insert(id);
}

void Map::GraftTree(KeyFrameId id, KeyFrameId parent) {
  while (id.IsValid()) {
    const KeyFrameId former = std::exchange(keyframe(id).parent, parent);
    moved_keyframes_.insert(id);
    parent = id;
    id = former;
  }
}

void Map::UpdateDescriptor(MapPoint& point) const {
  // More than this many views add nothing to a median but quadratic time.
  constexpr size_t kMaxViews = 16;
  std::array<const Descriptor*, kMaxViews> views{};
  size_t count = 0;
  const size_t total = point.observations.size();
  for (size_t i = total > kMaxViews ? total - kMaxViews : 0; i < total; ++i) {
    const Observation& observation = point.observations[i];
    views[count++] = &keyframes_.at(observation.keyframe).features->descriptors[observation.keypoint];
  }
  int best_median = 257;
  for (size_t i = 0; i < count; ++i) {
    std::array<int, kMaxViews> distances{};
    for (size_t j = 0; j < count; ++j) distances[j] = HammingDistance(*views[i], *views[j]);
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(distances.begin(), middle, distances.begin() + static_cast<std::ptrdiff_t>(count));
    if (*middle >= best_median) continue;
    best_median = *middle;
    point.descriptor = *views[i];
  }
}

void Map::UpdateGeometry(MapPoint& point) const {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (const Observation& observation : point.observations) {
    direction += (point.position_in_map - keyframes_.at(observation.keyframe).Center()).normalized();
  }
  point.normal = direction.normalized().cast<float>();
  const auto reference =
      std::find_if(point.observations.begin(), point.observations.end(),
                   [&](const Observation& o) { return o.keyframe == point.reference_keyframe; });
  const Observation& seen = reference == point.observations.end() ? point.observations.front() : *reference;
  const KeyFrame& keyframe = keyframes_.at(seen.keyframe);
  const double distance = (point.position_in_map - keyframe.Center()).norm();
  const auto octave = keyframe.features->keypoints[seen.keypoint].octave;
  point.max_distance = static_cast<float>(distance) * scale_info_.scales[octave];
  point.min_distance = point.max_distance / scale_info_.scales.back();
}

void Map::UpdateAppearance(MapPointId id) {
  const auto found = points_.find(id);
  if (found == points_.end() || found->second.observations.empty()) return;
  UpdateDescriptor(found->second);
  UpdateGeometry(found->second);
  changed_points_.insert(id);
}

void Map::UpdateViewing(MapPointId id) {
  const auto found = points_.find(id);
  if (found == points_.end() || found->second.observations.empty()) return;
  UpdateGeometry(found->second);
  changed_points_.insert(id);
}

void Map::Clear() {
  keyframes_.clear();
  points_.clear();
  heirs_.clear();
  removal_order_.clear();
  newest_keyframe_ = KeyFrameId();
  first_keyframe_ = KeyFrameId();
  added_keyframes_.clear();
  moved_keyframes_.clear();
  rescaled_keyframes_.clear();
  reobserved_keyframes_.clear();
  changed_points_.clear();
  new_points_.clear();
  removed_points_.clear();
  removed_keyframes_.clear();
  was_reset_ = true;
}

std::optional<RemovedKeyFrame> Map::FindHeir(KeyFrameId id) const {
  const auto found = heirs_.find(id);
  if (found == heirs_.end()) return std::nullopt;
  return found->second;
}

bool Map::Resolve(FramePose* frame) const {
  while (FindKeyFrame(frame->reference_keyframe) == nullptr) {
    const auto heir = FindHeir(frame->reference_keyframe);
    if (!heir) return false;
    frame->keyframe_from_camera = heir->heir_from_removed * frame->keyframe_from_camera;
    frame->reference_keyframe = heir->heir;
  }
  return true;
}

}  // namespace semmap
