#pragma once

#include <map>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "slam/common/mutex.h"
#include "slam/evaluation/trajectory.h"
#include "slam/map/map_delta.h"

namespace semmap {

// Listens to a session and composes the trajectory of its frames as the map has it in the end: each frame
// hangs on a keyframe and follows that keyframe's corrections; when the keyframe is culled it moves to the
// heir. A reset forgets everything. Keeps poses only, no features or points. Thread-safe.
class TrajectoryCollector : public MapDeltaSink {
 public:
  void OnDelta(MapDelta delta) override;

  // map_from_camera of every frame that belongs to a keyframe of the map, by growing sequence number.
  Trajectory Compose() const;
  // Sequence numbers, as long as Compose().
  std::vector<uint64_t> Sequences() const;

 private:
  struct Heir {
    KeyFrameId keyframe;
    SE3 heir_from_removed;
  };

  void Rescale(const KeyFramePose& moved) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::optional<SE3> Locate(const FramePose& frame) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable Mutex mutex_;
  std::map<KeyFrameId, SE3> keyframes_ ABSL_GUARDED_BY(mutex_);
  std::map<KeyFrameId, Heir> heirs_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, FramePose> frames_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap
