#pragma once

#include <atomic>
#include <memory>

#include "slam/pipeline/frame_order.h"
#include "slam/pipeline/map_localizer.h"
#include "slam/pipeline/map_snapshot.h"
#include "slam/pipeline/session.h"
#include "slam/pipeline/tracker.h"

namespace semmap {

// A vehicle that drives in a stored map and never changes it. A frame whose place is not known, at first and
// after a loss, is looked for in the whole map (MapLocalizer: bounded work, in the thread that brings it);
// from then on the tracker works in a view that moves along with the vehicle. There is no mapper: nothing
// happens between frames, and the same frames give the same poses. What is not in memory of the map is read
// in that thread, too; when that fails, so does Track, and the session is over.
class LocalizingSession : public Session {
 public:
  // `map` is not null. A rig with depth looks with one eye where the map's unit is arbitrary.
  LocalizingSession(const SlamConfig& config, const CameraRig& rig,
                    std::shared_ptr<SegmentationQueue> segmentation, std::shared_ptr<const MapSnapshot> map,
                    MapDeltaSink* sink);

  absl::StatusOr<FrameResult> Track(const FrameInput& frame) override;
  void WaitForMapper(int /*backlog*/) override {}
  void Finish() override { Deliver(); }
  SessionStats Stats() const override;

 private:
  // Looks for a frame whose place is unknown or doubted in the whole map.
  absl::Status Search(const LostFrame& lost, TrackOutput* output);
  absl::Status Adopt(const LostFrame& lost, const MapFix& found);
  // Moves the view to the keyframe that sees most of what the last frame saw.
  absl::Status Recenter();
  void Keep(const FramePose& pose);
  void Deliver();

  const std::shared_ptr<const MapSnapshot> map_;
  MapDeltaSink* const sink_;
  Tracker tracker_;
  MapLocalizer localizer_;
  FrameOrder order_;
  std::shared_ptr<const LocalMapView> view_;
  std::shared_ptr<const Recovery> recovery_;
  MapDelta delta_;
  uint64_t delta_version_ = 0;
  std::atomic<uint64_t> frames_ = 0;
  std::atomic<uint64_t> tracked_frames_ = 0;
  std::atomic<int> recoveries_ = 0;
  std::atomic<int> failed_recoveries_ = 0;
  std::atomic<LocalizationFailure> last_failure_ = LocalizationFailure::kNone;
};

}  // namespace semmap
