#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/geometry/camera.h"
#include "slam/map/map_delta.h"
#include "slam/pipeline/executor.h"
#include "slam/pipeline/frame.h"
#include "slam/pipeline/map_snapshot.h"
#include "slam/pipeline/slam_config.h"
#include "slam/pipeline/view_localizer.h"
#include "slam/place/vocabulary.h"
#include "slam/semantics/segmentation_queue.h"

namespace semmap {

class SharedMap;

// Totals of a session, for summaries and metrics.
struct SessionStats {
  int keyframes = 0;
  int points = 0;
  uint64_t frames = 0;
  uint64_t tracked_frames = 0;
  double map_ms = 0;  // wall time spent in the mapper so far
  int loops = 0;      // closed
  // Lost frames that were found in the map, and that were not; and why the last one was not.
  int recoveries = 0;
  int failed_recoveries = 0;
  LocalizationFailure last_recovery_failure = LocalizationFailure::kNone;
  // Frames whose keypoints have classes, in time or as keyframes later; and those for which classes were
  // wanted and did not come.
  uint64_t classified_frames = 0;
  uint64_t unclassified_frames = 0;
  // What the vehicle mapped on its own before it was found in a map that others made, and that became part of
  // it.
  int joined_pieces = 0;
};

// The map that a session begins with; at most one of both. Without, it makes a map alone.
struct SessionStart {
  // Finds itself in it and never changes it: tracks within it, reports poses, and delivers nothing but the
  // poses of its frames. Shared with whoever else reads it. Such a session needs no executor.
  std::shared_ptr<const MapSnapshot> localize;
  // Adds to it, together with all other sessions that begin with the same. Unless it is the first in a new
  // map, it must find itself there before; until then it maps a piece of its own, in whose frame it is
  // answered, and which becomes part of the map as soon as both show one place, or at the end of the drive. A
  // piece that never shows a place of the map is dropped.
  std::shared_ptr<SharedMap> shared;
};

// One vehicle's drive: joins tracker and mapper. Track is called from one thread at a time (any thread); the
// mapper runs on `executor` in order, or inside Track when the configuration asks for determinism. Frames
// must have growing sequence numbers and timestamps. After an error of Track (wrong image size or type, time
// running backwards) the session is as it was before the call.
class Session {
 public:
  // INVALID_ARGUMENT when the rig or the configuration is not usable. `sink` and `executor` must outlive the
  // session. Without a vocabulary the session finds neither loops nor, once lost, its way back into parts of
  // the map that are not near, and never finds itself in a stored map. Without a segmentation queue only
  // frames that bring a mask have classes.
  static absl::StatusOr<std::unique_ptr<Session>> Create(
      const SlamConfig& config, const CameraRig& rig, MapDeltaSink* sink, Executor* executor,
      std::shared_ptr<const Vocabulary> vocabulary = nullptr,
      std::shared_ptr<SegmentationQueue> segmentation = nullptr, SessionStart start = {});
  virtual ~Session() = default;

  virtual absl::StatusOr<FrameResult> Track(const FrameInput& frame) = 0;
  // Returns once at most `backlog` keyframes wait for the mapper or are being mapped. Who feeds recorded
  // frames faster than they were taken calls it before each Track, so that the map keeps up; who feeds live
  // frames does not.
  virtual void WaitForMapper(int backlog) = 0;
  // Waits for the mapper and delivers what is left to the sink. Idempotent; Track must not be called
  // afterwards.
  virtual void Finish() = 0;
  virtual SessionStats Stats() const = 0;
};

}  // namespace semmap
