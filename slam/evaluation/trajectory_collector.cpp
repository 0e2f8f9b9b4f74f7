#include "slam/evaluation/trajectory_collector.h"

namespace semmap {

void TrajectoryCollector::OnDelta(MapDelta delta) {
  const MutexLock lock(&mutex_);
  if (delta.reset) {
    keyframes_.clear();
    heirs_.clear();
    frames_.clear();
  }
  for (const KeyFrameRecord& keyframe : delta.added_keyframes)
    keyframes_[keyframe.id] = keyframe.map_from_camera;
  for (const KeyFramePose& keyframe : delta.moved_keyframes) {
    const auto known = keyframes_.find(keyframe.id);
    if (known != keyframes_.end()) known->second = keyframe.map_from_camera;
    if (keyframe.rescale != 1) Rescale(keyframe);
  }
  for (const RemovedKeyFrame& removed : delta.removed_keyframes) {
    keyframes_.erase(removed.removed);
    heirs_[removed.removed] = {removed.heir, removed.heir_from_removed};
  }
  for (const FramePose& frame : delta.frames) frames_[frame.sequence] = frame;
}

// What hangs on the keyframe, directly or as what a culled keyframe left to it, keeps its distance in the new
// unit.
void TrajectoryCollector::Rescale(const KeyFramePose& moved) {
  const auto grow = [&](SE3& pose) { pose = SE3(pose.rotation(), moved.rescale * pose.translation()); };
  for (auto& [sequence, frame] : frames_) {
    if (frame.reference_keyframe == moved.id) grow(frame.keyframe_from_camera);
  }
  for (auto& [id, heir] : heirs_) {
    if (heir.keyframe == moved.id) grow(heir.heir_from_removed);
  }
}

std::optional<SE3> TrajectoryCollector::Locate(const FramePose& frame) const {
  KeyFrameId id = frame.reference_keyframe;
  SE3 keyframe_from_camera = frame.keyframe_from_camera;
  // An heir may be culled in turn. No chain is longer than the number of keyframes ever removed.
  for (size_t step = 0; step <= heirs_.size(); ++step) {
    const auto keyframe = keyframes_.find(id);
    if (keyframe != keyframes_.end()) return keyframe->second * keyframe_from_camera;
    const auto heir = heirs_.find(id);
    if (heir == heirs_.end()) break;
    keyframe_from_camera = heir->second.heir_from_removed * keyframe_from_camera;
    id = heir->second.keyframe;
  }
  return std::nullopt;
}

Trajectory TrajectoryCollector::Compose() const {
  const MutexLock lock(&mutex_);
  Trajectory trajectory;
  for (const auto& [sequence, frame] : frames_) {
    const std::optional<SE3> map_from_camera = Locate(frame);
    if (map_from_camera) trajectory.poses.push_back({frame.timestamp, *map_from_camera});
  }
  return trajectory;
}

std::vector<uint64_t> TrajectoryCollector::Sequences() const {
  const MutexLock lock(&mutex_);
  std::vector<uint64_t> sequences;
  for (const auto& [sequence, frame] : frames_) {
    if (Locate(frame)) sequences.push_back(sequence);
  }
  return sequences;
}

}  // namespace semmap
