#include "storage/map_loader.h"

#include <unordered_map>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/map/map_restorer.h"

namespace semmap::storage {
namespace {

class Loader : public MapReader {
 public:
  Loader(const ScalePyramidInfo& scale_info, size_t max_bytes, PointClassPolicy classes)
      : scale_info_(scale_info), max_bytes_(max_bytes), classes_(classes) {}

  absl::Status OnMap(const MapInfo& map) override {
    info_ = map;
    restorer_.emplace(scale_info_, map.last_point_id, classes_);
    return absl::OkStatus();
  }

  absl::Status OnSession(const SessionInfo& session) override {
    bounds_[session.id] = UndistortedBounds(session.rig.camera);
    return absl::OkStatus();
  }

  absl::Status OnPoint(const MapPointRecord& point) override {
    SEMMAP_RETURN_IF_ERROR(restorer_->AddPoint(point));
    return CheckSize();
  }

  absl::Status OnKeyFrame(const KeyFrameEntry& keyframe, KeyFrameObservations observations) override {
    const auto bounds = bounds_.find(keyframe.session);
    if (bounds == bounds_.end()) {
      return absl::DataLossError(
          absl::StrCat("keyframe ", keyframe.record.id.value(), " belongs to no session"));
    }
    SEMMAP_RETURN_IF_ERROR(
        restorer_->AddKeyFrame(keyframe.record, bounds->second, std::move(observations.point_of_keypoint)));
    return CheckSize();
  }

  absl::StatusOr<RestoredMap> Finish() && {
    const size_t bytes = restorer_->memory_bytes();
    SEMMAP_ASSIGN_OR_RETURN(Map map, std::move(*restorer_).Finish());
    return RestoredMap{std::move(info_), std::move(map), bytes};
  }

 private:
  absl::Status CheckSize() const {
    if (restorer_->memory_bytes() <= max_bytes_) return absl::OkStatus();
    return absl::ResourceExhaustedError(
        absl::StrCat("the map takes more than ", max_bytes_ >> 20, " MB of memory"));
  }

  const ScalePyramidInfo& scale_info_;
  const size_t max_bytes_;
  const PointClassPolicy classes_;
  MapInfo info_;
  std::optional<MapRestorer> restorer_;
  std::unordered_map<SessionId, ImageBounds, IdHash> bounds_;
};

}  // namespace

absl::StatusOr<RestoredMap> LoadMap(MapStore& store, MapId map, const ScalePyramidInfo& scale_info,
                                    size_t max_bytes, PointClassPolicy classes) {
  Loader loader(scale_info, max_bytes, classes);
  SEMMAP_RETURN_IF_ERROR(store.ReadWhole(map, &loader));
  return std::move(loader).Finish();
}

}  // namespace semmap::storage
