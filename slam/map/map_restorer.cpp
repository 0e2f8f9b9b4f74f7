#include "slam/map/map_restorer.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap {
namespace {

// What a node of an unordered container takes besides its value: two pointers of the heap, a link and a
// bucket.
constexpr size_t kNodeBytes = 32;

template <typename... Parts>
absl::Status Contradiction(const Parts&... parts) {
  return absl::DataLossError(absl::StrCat(parts...));
}

size_t BytesOf(const KeyFrame& keyframe) {
  constexpr size_t kBytesPerKeypoint =
      sizeof(Keypoint) + sizeof(Descriptor) + sizeof(MapPointId) + sizeof(uint16_t);
  return sizeof(KeyFrame) + sizeof(FeatureGrid) + sizeof(FrameFeatures) + kNodeBytes +
         keyframe.features->size() * kBytesPerKeypoint;
}

}  // namespace

MapRestorer::MapRestorer(const ScalePyramidInfo& scale_info, MapPointId last_point, PointClassPolicy classes)
    : map_(scale_info, classes) {
  map_.next_point_id_ = last_point.value() + 1;
}

absl::Status MapRestorer::AddPoint(const MapPointRecord& record) {
  MapPoint point;
  point.id = record.id;
  point.position_in_map = record.position_in_map;
  point.reference_keyframe = record.reference_keyframe;
  point.descriptor = record.descriptor;
  point.normal = record.normal;
  point.min_distance = record.min_distance;
  point.max_distance = record.max_distance;
  point.votes = ClassVotes(record.votes);
  map_.Reclassify(&point);
  point.observations.reserve(std::min<uint32_t>(record.observation_count, 1000));
  memory_bytes_ += sizeof(MapPoint) + kNodeBytes + point.observations.capacity() * sizeof(Observation);
  map_.next_point_id_ = std::max(map_.next_point_id_, record.id.value() + 1);
  if (map_.points_.emplace(record.id, std::move(point)).second) return absl::OkStatus();
  return Contradiction("point ", record.id.value(), " occurs twice");
}

absl::Status MapRestorer::AddKeyFrame(const KeyFrameRecord& record, const ImageBounds& bounds,
                                      std::vector<MapPointId> observations) {
  const std::vector<Keypoint>& keypoints = record.features->keypoints;
  if (observations.size() != keypoints.size())
    return Contradiction("keyframe ", record.id.value(), " has not as many observations as keypoints");
  if (std::any_of(keypoints.begin(), keypoints.end(),
                  [&](const Keypoint& k) { return k.octave >= map_.scale_info_.levels(); })) {
    return Contradiction("keyframe ", record.id.value(),
                         " has keypoints of more pyramid levels than configured");
  }
  KeyFrame keyframe;
  keyframe.id = record.id;
  keyframe.sequence = record.sequence;
  keyframe.timestamp = record.timestamp;
  keyframe.camera_from_map = record.map_from_camera.Inverse();
  keyframe.parent = record.parent;
  keyframe.features = record.features;
  keyframe.grid = std::make_shared<FeatureGrid>(bounds, keypoints);
  keyframe.points.resize(keypoints.size());
  memory_bytes_ += BytesOf(keyframe);
  if (map_.FindKeyFrame(record.id) != nullptr)
    return Contradiction("keyframe ", record.id.value(), " occurs twice");
  map_.AddKeyFrame(std::move(keyframe));
  for (uint32_t i = 0; i < observations.size(); ++i) {
    if (observations[i].IsValid()) SEMMAP_RETURN_IF_ERROR(Observe(observations[i], record.id, i));
  }
  memory_bytes_ +=
      map_.FindKeyFrame(record.id)->covisible.size() * 2 * (kNodeBytes + sizeof(std::pair<KeyFrameId, int>));
  return absl::OkStatus();
}

absl::Status MapRestorer::Observe(MapPointId point, KeyFrameId keyframe, uint32_t keypoint) {
  const auto found = map_.points_.find(point);
  if (found == map_.points_.end())
    return Contradiction("keyframe ", keyframe.value(), " sees point ", point.value(),
                         ", which is not there");
  if (map_.Attach(&found->second, &map_.keyframe(keyframe), keypoint)) return absl::OkStatus();
  return Contradiction("keyframe ", keyframe.value(), " sees point ", point.value(), " twice");
}

absl::StatusOr<Map> MapRestorer::Finish() && {
  KeyFrameId first;
  KeyFrameId newest;
  for (const auto& [id, keyframe] : map_.keyframes_) {
    if (keyframe.parent.IsValid() && map_.FindKeyFrame(keyframe.parent) == nullptr)
      return Contradiction("keyframe ", id.value(), " has no parent ", keyframe.parent.value());
    first = first.IsValid() ? std::min(first, id) : id;
    newest = std::max(newest, id);
  }
  map_.first_keyframe_ = first;
  map_.newest_keyframe_ = newest;
  map_.TakeDelta();
  return std::move(map_);
}

}  // namespace semmap
