#include "slam/pipeline/piece_join.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "slam/pipeline/map_joiner.h"

namespace semmap {
namespace {

// One piece on its way into a map.
class Joining {
 public:
  Joining(const PieceJoin& join, PlaceMemory* places, Map* map)
      : piece_(*join.piece), places_(*places), map_(*map) {
    for (const auto& [id, keyframe] : map_.keyframes()) last_of_map_ = std::max(last_of_map_, id);
    std::vector<KeyFrameId> old_ids;
    for (const auto& [id, keyframe] : piece_.map.keyframes()) old_ids.push_back(id);
    std::sort(old_ids.begin(), old_ids.end());
    for (const KeyFrameId id : old_ids) {
      ids_.emplace(id, join.ids->Next());
      new_ids_.push_back(ids_.at(id));
    }
  }

  KeyFrameId last_of_map() const { return last_of_map_; }

  void LayBeside() {
    map_.Append(piece_.map, ids_);
    for (const KeyFrameId id : new_ids_) places_.Add(*map_.FindKeyFrame(id));
  }

  void TakeAway() {
    for (const KeyFrameId id : new_ids_) places_.Remove(id);
    map_.Drop(new_ids_);
  }

  // The frame that was found in the map, as the piece knows it.
  std::optional<FramePose> Same(const FramePose& found) const {
    const auto same = std::find_if(piece_.frames.begin(), piece_.frames.end(),
                                   [&](const FramePose& frame) { return frame.sequence == found.sequence; });
    if (same == piece_.frames.end()) return std::nullopt;
    FramePose frame = *same;
    return piece_.map.Resolve(&frame) ? std::optional(frame) : std::nullopt;
  }

  bool IsSure(const MapOverlap& overlap, const MergeConfig& config,
              const std::optional<FramePose>& found) const {
    if (overlap.IsSound(config)) return true;
    const auto same = found ? Same(*found) : std::nullopt;
    return same && overlap.IsConfirmedBy(PoseOf(piece_.map, *same), PoseOf(map_, *found));
  }

  // By the frame alone that was found; nullopt when the piece does not know it.
  std::optional<MapOverlap> OverlapBy(const FramePose& found) const {
    const auto same = Same(found);
    if (!same || map_.FindKeyFrame(found.reference_keyframe) == nullptr) return std::nullopt;
    MapOverlap overlap;
    overlap.keyframes = static_cast<int>(new_ids_.size());
    overlap.target_from_source = {1, PoseOf(map_, found) * PoseOf(piece_.map, *same).Inverse()};
    Loop link;
    link.old = found.reference_keyframe;
    link.current = ids_.at(same->reference_keyframe);
    link.old_from_current = {1, found.keyframe_from_camera * same->keyframe_from_camera.Inverse()};
    overlap.links.push_back(std::move(link));
    return overlap;
  }

  std::vector<FramePose> Frames() const {
    std::vector<FramePose> frames;
    for (FramePose frame : piece_.frames) {
      if (!piece_.map.Resolve(&frame)) continue;
      frame.reference_keyframe = ids_.at(frame.reference_keyframe);
      const double scale = map_.RescaledBy(frame.reference_keyframe);
      const SE3& pose = frame.keyframe_from_camera;
      frame.keyframe_from_camera = SE3(pose.rotation(), scale * pose.translation());
      frames.push_back(frame);
    }
    return frames;
  }

  std::vector<PieceJoinReport::Moved> KeyFrames() const {
    std::vector<PieceJoinReport::Moved> moved;
    for (const auto& [old_id, id] : ids_) {
      const KeyFrame& keyframe = *piece_.map.FindKeyFrame(old_id);
      moved.push_back({id, keyframe.sequence, keyframe.camera_from_map.Inverse(), map_.RescaledBy(id)});
    }
    return moved;
  }

 private:
  static SE3 PoseOf(const Map& map, const FramePose& frame) {
    return map.FindKeyFrame(frame.reference_keyframe)->camera_from_map.Inverse() * frame.keyframe_from_camera;
  }

  const MapPiece& piece_;
  PlaceMemory& places_;
  Map& map_;
  KeyFrameId last_of_map_;
  KeyFrameIdMap ids_;
  std::vector<KeyFrameId> new_ids_;
};

}  // namespace

PieceJoinReport JoinPiece(const SlamConfig& config, const MappingCamera& camera, const PieceJoin& join,
                          PlaceMemory* places, Map* map) {
  PieceJoinReport report;
  if (!places->enabled() || map->keyframes().empty()) return report;
  Joining joining(join, places, map);
  joining.LayBeside();
  // Nobody cancels it.
  report.overlap = *FindOverlap(config, camera, *places, *map, joining.last_of_map(), nullptr);
  report.joined = joining.IsSure(report.overlap, config.merge, join.found);
  if (!report.joined && join.trust_found && join.found && camera.HasDepth()) {
    if (auto overlap = joining.OverlapBy(*join.found)) {
      report.overlap = *std::move(overlap);
      report.joined = true;
    }
  }
  if (!report.joined) {
    joining.TakeAway();
    return report;
  }
  MapJoiner joiner(config, camera, report.overlap, joining.last_of_map(), !camera.HasDepth(), map);
  joiner.Align(nullptr);
  report.fused_points = joiner.Fuse(nullptr);
  report.frames = joining.Frames();
  report.keyframes = joining.KeyFrames();
  return report;
}

}  // namespace semmap
