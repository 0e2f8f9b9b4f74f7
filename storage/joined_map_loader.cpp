#include "storage/joined_map_loader.h"

#include <memory>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/map/map_restorer.h"

namespace semmap::storage {
namespace {

// Adds one map to a restorer that may hold another one.
class Side : public MapReader {
 public:
  Side(uint64_t keyframe_offset, uint64_t point_offset, bool forget_depth, size_t max_bytes,
       MapRestorer* restorer)
      : keyframe_offset_(keyframe_offset),
        point_offset_(point_offset),
        forget_depth_(forget_depth),
        max_bytes_(max_bytes),
        restorer_(restorer) {}

  const MapInfo& info() const { return info_; }

  absl::Status OnMap(const MapInfo& map) override {
    info_ = map;
    return absl::OkStatus();
  }

  absl::Status OnSession(const SessionInfo& session) override {
    bounds_[session.id] = UndistortedBounds(session.rig.camera);
    return absl::OkStatus();
  }

  absl::Status OnPoint(const MapPointRecord& point) override {
    MapPointRecord moved = point;
    moved.id = Moved(point.id);
    moved.reference_keyframe = Moved(point.reference_keyframe);
    SEMMAP_RETURN_IF_ERROR(restorer_->AddPoint(moved));
    return CheckSize();
  }

  absl::Status OnKeyFrame(const KeyFrameEntry& keyframe, KeyFrameObservations observations) override {
    const auto bounds = bounds_.find(keyframe.session);
    if (bounds == bounds_.end()) {
      return absl::DataLossError(
          absl::StrCat("keyframe ", keyframe.record.id.value(), " belongs to no session"));
    }
    KeyFrameRecord moved = keyframe.record;
    moved.id = Moved(moved.id);
    if (moved.parent.IsValid()) moved.parent = Moved(moved.parent);
    if (forget_depth_) moved.features = std::make_shared<const FrameFeatures>(WithoutDepth(*moved.features));
    for (MapPointId& point : observations.point_of_keypoint) {
      if (point.IsValid()) point = Moved(point);
    }
    SEMMAP_RETURN_IF_ERROR(
        restorer_->AddKeyFrame(moved, bounds->second, std::move(observations.point_of_keypoint)));
    return CheckSize();
  }

 private:
  KeyFrameId Moved(KeyFrameId id) const { return KeyFrameId(id.value() + keyframe_offset_); }
  MapPointId Moved(MapPointId id) const { return MapPointId(id.value() + point_offset_); }

  absl::Status CheckSize() const {
    if (restorer_->memory_bytes() <= max_bytes_) return absl::OkStatus();
    return absl::ResourceExhaustedError(
        absl::StrCat("the maps together take more than ", max_bytes_ >> 20, " MB of memory"));
  }

  const uint64_t keyframe_offset_;
  const uint64_t point_offset_;
  const bool forget_depth_;
  const size_t max_bytes_;
  MapRestorer* const restorer_;
  MapInfo info_;
  std::unordered_map<SessionId, ImageBounds, IdHash> bounds_;
};

}  // namespace

FrameFeatures WithoutDepth(FrameFeatures features) {
  for (Keypoint& keypoint : features.keypoints) {
    keypoint.right_x = -1;
    keypoint.depth = -1;
  }
  return features;
}

absl::StatusOr<JoinedMaps> LoadJoinedMaps(MapStore& store, MapId target, MapId source,
                                          const ScalePyramidInfo& scale_info, size_t max_bytes,
                                          const PointClassPolicy& classes, bool forget_depth) {
  SEMMAP_ASSIGN_OR_RETURN(const MapInfo info, store.GetMap(target));
  MapRestorer restorer(scale_info, info.last_point_id, classes);
  Side target_side(0, 0, forget_depth, max_bytes, &restorer);
  SEMMAP_RETURN_IF_ERROR(store.ReadWhole(target, &target_side));
  const MapInfo& read = target_side.info();
  Side source_side(read.last_keyframe_id.value(), read.last_point_id.value(), forget_depth, max_bytes,
                   &restorer);
  SEMMAP_RETURN_IF_ERROR(store.ReadWhole(source, &source_side));
  const size_t bytes = restorer.memory_bytes();
  SEMMAP_ASSIGN_OR_RETURN(Map map, std::move(restorer).Finish());
  return JoinedMaps{read, source_side.info(), std::move(map), bytes};
}

}  // namespace semmap::storage
