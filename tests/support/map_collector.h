#pragma once

#include <map>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/map/map.h"
#include "slam/map/map_delta.h"
#include "slam/map/map_restorer.h"

namespace semmap::testing {

// Keeps what a session delivers as a store would, in memory, and gives it back as a map.
class MapCollector : public MapDeltaSink {
 public:
  MapCollector(const ScalePyramidInfo& scale_info, const ImageBounds& bounds)
      : scale_info_(scale_info), bounds_(bounds) {}

  void OnDelta(MapDelta delta) override {
    for (const KeyFrameRecord& keyframe : delta.added_keyframes) keyframes_[keyframe.id] = keyframe;
    for (const KeyFramePose& moved : delta.moved_keyframes) {
      keyframes_[moved.id].map_from_camera = moved.map_from_camera;
      keyframes_[moved.id].parent = moved.parent;
    }
    for (const MapPointRecord& point : delta.upserted_points) points_[point.id] = point;
    for (const KeyFrameObservations& seen : delta.observations)
      observations_[seen.id] = seen.point_of_keypoint;
    for (const RemovedKeyFrame& removed : delta.removed_keyframes) {
      keyframes_.erase(removed.removed);
      observations_.erase(removed.removed);
    }
    for (const MapPointId id : delta.removed_points) points_.erase(id);
    deltas_.push_back(std::move(delta));
  }

  const std::vector<MapDelta>& deltas() const { return deltas_; }
  const std::map<KeyFrameId, KeyFrameRecord>& keyframes() const { return keyframes_; }
  KeyFrameId last_keyframe() const { return keyframes_.empty() ? KeyFrameId() : keyframes_.rbegin()->first; }
  MapPointId last_point() const { return points_.empty() ? MapPointId() : points_.rbegin()->first; }

  absl::StatusOr<Map> Restore() const {
    MapRestorer restorer(scale_info_, last_point());
    for (const auto& [id, point] : points_) {
      if (const absl::Status status = restorer.AddPoint(point); !status.ok()) return status;
    }
    for (const auto& [id, keyframe] : keyframes_) {
      const auto seen = observations_.find(id);
      std::vector<MapPointId> points(keyframe.features->size());
      if (seen != observations_.end()) points = seen->second;
      const absl::Status status = restorer.AddKeyFrame(keyframe, bounds_, std::move(points));
      if (!status.ok()) return status;
    }
    return std::move(restorer).Finish();
  }

 private:
  ScalePyramidInfo scale_info_;
  ImageBounds bounds_;
  std::vector<MapDelta> deltas_;
  std::map<KeyFrameId, KeyFrameRecord> keyframes_;
  std::map<MapPointId, MapPointRecord> points_;
  std::map<KeyFrameId, std::vector<MapPointId>> observations_;
};

}  // namespace semmap::testing
