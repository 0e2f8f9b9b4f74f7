#include "slam/pipeline/session.h"

#include <atomic>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/pipeline/mapper_queue.h"
#include "slam/pipeline/tracker.h"

namespace semmap {
namespace {

class SlamSession : public Session {
 public:
  SlamSession(const SlamConfig& config, const CameraRig& rig, MapDeltaSink* sink, Executor* executor,
              std::shared_ptr<const Vocabulary> vocabulary)
      : tracker_(config, rig),
        queue_(config, tracker_.camera(), tracker_.builder().scale_info(), std::move(vocabulary), sink,
               config.deterministic ? nullptr : executor) {}

  absl::StatusOr<FrameResult> Track(const FrameInput& frame) override {
    SEMMAP_RETURN_IF_ERROR(CheckOrder(frame));
    SEMMAP_RETURN_IF_ERROR(tracker_.Check(frame));
    last_sequence_ = frame.sequence;
    last_timestamp_ = frame.timestamp;
    ++frames_;
    TrackOutput output = tracker_.Track(frame, queue_.State());
    const bool starts_map =
        output.initial_pair.has_value() || output.result.map_version == 0 || output.reset_map;
    if (output.result.state == TrackingState::kTracking) ++tracked_frames_;
    queue_.Push(&output);
    // A map begins, or begins anew: the next frame needs it, and no later one waits again.
    if (starts_map) queue_.WaitForBacklog(0);
    return output.result;
  }

  void WaitForMapper(int backlog) override { queue_.WaitForBacklog(static_cast<size_t>(backlog)); }

  void Finish() override { queue_.Finish(); }

  SessionStats Stats() const override {
    const MapperQueue::Counts counts = queue_.counts();
    return {counts.keyframes,   counts.points, frames_,           tracked_frames_,
            counts.map_ms,      counts.loops,  counts.recoveries, counts.failed_recoveries,
            counts.last_failure};
  }

 private:
  absl::Status CheckOrder(const FrameInput& frame) const {
    if (frames_ == 0) return absl::OkStatus();
    if (frame.sequence <= last_sequence_) {
      return absl::InvalidArgumentError(
          absl::StrCat("sequence number ", frame.sequence, " follows ", last_sequence_));
    }
    if (frame.timestamp <= last_timestamp_) {
      return absl::InvalidArgumentError(
          absl::StrCat("timestamp ", frame.timestamp, " ns follows ", last_timestamp_, " ns"));
    }
    return absl::OkStatus();
  }

  Tracker tracker_;
  MapperQueue queue_;
  uint64_t last_sequence_ = 0;
  TimestampNs last_timestamp_ = 0;
  std::atomic<uint64_t> frames_ = 0;
  std::atomic<uint64_t> tracked_frames_ = 0;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Session>> Session::Create(const SlamConfig& config, const CameraRig& rig,
                                                         MapDeltaSink* sink, Executor* executor,
                                                         std::shared_ptr<const Vocabulary> vocabulary) {
  SEMMAP_RETURN_IF_ERROR(ValidateRig(rig));
  if (sink == nullptr || (executor == nullptr && !config.deterministic)) {
    return absl::InvalidArgumentError("a session needs a sink, and an executor unless it is deterministic");
  }
  return std::make_unique<SlamSession>(config, rig, sink, executor, std::move(vocabulary));
}

}  // namespace semmap
