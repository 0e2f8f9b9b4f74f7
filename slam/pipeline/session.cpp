#include "slam/pipeline/session.h"

#include <atomic>
#include <utility>

#include "slam/common/status_macros.h"
#include "slam/pipeline/frame_order.h"
#include "slam/pipeline/localizing_session.h"
#include "slam/pipeline/mapper_queue.h"
#include "slam/pipeline/shared_map.h"
#include "slam/pipeline/tracker.h"

namespace semmap {
namespace {

class SlamSession : public Session {
 public:
  SlamSession(const SlamConfig& config, const CameraRig& rig, MapDeltaSink* sink, Executor* executor,
              std::shared_ptr<const Vocabulary> vocabulary, std::shared_ptr<SegmentationQueue> segmentation,
              const std::shared_ptr<SharedMap>& shared)
      : tracker_(config, rig, std::move(segmentation)),
        mapper_(
            MapperOf(shared.get(), config, std::move(vocabulary), config.deterministic ? nullptr : executor),
            sink),
        is_stranger_(mapper_.State().map_is_strange) {
    if (shared != nullptr) tracker_.TakeIdsFrom(shared->ids());
  }

  absl::StatusOr<FrameResult> Track(const FrameInput& frame) override {
    SEMMAP_RETURN_IF_ERROR(order_.Check(frame));
    SEMMAP_RETURN_IF_ERROR(tracker_.Check(frame));
    order_.Take(frame);
    ++frames_;
    TrackOutput output = tracker_.Track(frame, mapper_.State());
    const bool starts_map = !is_stranger_ && (output.initial_pair.has_value() ||
                                              output.result.map_version == 0 || output.reset_map);
    if (output.result.state == TrackingState::kTracking) ++tracked_frames_;
    if (is_stranger_ && output.result.state == TrackingState::kLost)
      output.result.failure = mapper_.counts().last_failure;
    if (output.result.classes == ClassState::kKnown) ++classified_frames_;
    if (output.result.classes == ClassState::kMissed) ++unclassified_frames_;
    mapper_.Push(&output);
    // A map begins, or begins anew: the next frame needs it, and no later one waits again.
    if (starts_map) mapper_.WaitForBacklog(0);
    return output.result;
  }

  void WaitForMapper(int backlog) override { mapper_.WaitForBacklog(static_cast<size_t>(backlog)); }

  void Finish() override { mapper_.Finish(); }

  SessionStats Stats() const override {
    const MapperQueue::Counts counts = mapper_.counts();
    return {counts.keyframes,
            counts.points,
            frames_,
            tracked_frames_,
            counts.map_ms,
            counts.loops,
            counts.recoveries,
            counts.failed_recoveries,
            counts.last_failure,
            classified_frames_ + counts.classified_keyframes,
            unclassified_frames_ + counts.unclassified_keyframes};
  }

 private:
  std::shared_ptr<MapperQueue> MapperOf(SharedMap* shared, const SlamConfig& config,
                                        std::shared_ptr<const Vocabulary> vocabulary, Executor* executor) {
    const ScalePyramidInfo& scale_info = tracker_.builder().scale_info();
    if (shared != nullptr)
      return shared->Mapper(config, tracker_.camera(), scale_info, std::move(vocabulary), executor);
    return std::make_shared<MapperQueue>(config, tracker_.camera(), scale_info, std::move(vocabulary),
                                         executor);
  }

  Tracker tracker_;
  MapperSeat mapper_;
  // The map was there before: no frame waits for it to begin.
  const bool is_stranger_;
  FrameOrder order_;
  std::atomic<uint64_t> frames_ = 0;
  std::atomic<uint64_t> tracked_frames_ = 0;
  std::atomic<uint64_t> classified_frames_ = 0;
  std::atomic<uint64_t> unclassified_frames_ = 0;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Session>> Session::Create(const SlamConfig& config, const CameraRig& rig,
                                                         MapDeltaSink* sink, Executor* executor,
                                                         std::shared_ptr<const Vocabulary> vocabulary,
                                                         std::shared_ptr<SegmentationQueue> segmentation,
                                                         SessionStart start) {
  SEMMAP_RETURN_IF_ERROR(ValidateRig(rig));
  if (sink == nullptr || (executor == nullptr && !config.deterministic && start.localize == nullptr)) {
    return absl::InvalidArgumentError("a session needs a sink, and an executor unless it is deterministic");
  }
  if (start.localize != nullptr) {
    return std::make_unique<LocalizingSession>(config, rig, std::move(segmentation),
                                               std::move(start.localize), sink);
  }
  return std::make_unique<SlamSession>(config, rig, sink, executor, std::move(vocabulary),
                                       std::move(segmentation), start.shared);
}

}  // namespace semmap
