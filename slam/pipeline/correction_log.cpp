#include "slam/pipeline/correction_log.h"

#include <algorithm>
#include <limits>

namespace semmap {

void CorrectionLog::Note(const MapDelta& delta, bool own) {
  if (delta.reset) keyframes_.clear();
  for (const KeyFrameRecord& added : delta.added_keyframes) {
    if (!own) break;
    Entry entry{added.sequence, added.map_from_camera, added.map_from_camera, 1.0};
    keyframes_.try_emplace(added.id, entry).first->second.map_from_camera_now = added.map_from_camera;
  }
  for (const KeyFramePose& moved : delta.moved_keyframes) {
    const auto known = keyframes_.find(moved.id);
    if (known == keyframes_.end()) continue;
    known->second.map_from_camera_now = moved.map_from_camera;
    known->second.scale *= moved.rescale;
  }
  for (const RemovedKeyFrame& removed : delta.removed_keyframes) keyframes_.erase(removed.removed);
}

void CorrectionLog::NoteReportedElsewhere(KeyFrameId id, uint64_t sequence, const SE3& elsewhere_from_camera,
                                          double scale) {
  keyframes_[id] = {sequence, elsewhere_from_camera, elsewhere_from_camera, scale};
}

std::vector<PoseCorrection> CorrectionLog::Corrections() const {
  // In the order of the drive; a piece that was joined later has later ids.
  std::vector<Entry> entries;
  for (const auto& [id, keyframe] : keyframes_) entries.push_back(keyframe);
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.sequence < b.sequence; });
  std::vector<PoseCorrection> corrections;
  for (const Entry& keyframe : entries) {
    if (!corrections.empty()) corrections.back().through_sequence = keyframe.sequence - 1;
    const Sim3 corrected_from_camera{keyframe.scale, keyframe.map_from_camera_now};
    const Sim3 camera_from_reported{1.0, keyframe.map_from_camera_then.Inverse()};
    corrections.push_back({keyframe.sequence, std::numeric_limits<uint64_t>::max(),
                           corrected_from_camera * camera_from_reported});
  }
  return corrections;
}

}  // namespace semmap
