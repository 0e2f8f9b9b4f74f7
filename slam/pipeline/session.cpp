#include "slam/pipeline/session.h"

#include <atomic>
#include <optional>
#include <utility>

#include "slam/common/status_macros.h"
#include "slam/pipeline/frame_order.h"
#include "slam/pipeline/localizing_session.h"
#include "slam/pipeline/mapper_queue.h"
#include "slam/pipeline/own_piece.h"
#include "slam/pipeline/shared_map.h"
#include "slam/pipeline/tracker.h"

namespace semmap {
namespace {

// While the vehicle's own piece is at home in places that it knows, it is looked for in the map with every so
// many frames.
constexpr int kFramesBetweenSearches = 5;

class SlamSession : public Session {
 public:
  SlamSession(const SlamConfig& config, const CameraRig& rig, MapDeltaSink* sink, Executor* executor,
              std::shared_ptr<const Vocabulary> vocabulary, std::shared_ptr<SegmentationQueue> segmentation,
              const std::shared_ptr<SharedMap>& shared)
      : tracker_(config, rig, std::move(segmentation)),
        mapper_(MapperOf(shared.get(), config, vocabulary, executor), sink),
        ids_(shared != nullptr ? shared->ids() : std::make_shared<KeyFrameIdSource>()),
        is_stranger_(mapper_.State().map_is_strange),
        handover_(&mapper_, ids_) {
    if (is_stranger_) {
      piece_.emplace(config, tracker_.camera(), tracker_.builder().scale_info(), std::move(vocabulary),
                     executor);
    } else {
      tracker_.TakeIdsFrom(ids_);
    }
  }

  absl::StatusOr<FrameResult> Track(const FrameInput& frame) override {
    SEMMAP_RETURN_IF_ERROR(order_.Check(frame));
    SEMMAP_RETURN_IF_ERROR(tracker_.Check(frame));
    order_.Take(frame);
    ++frames_;
    const MapperState state = mapper_.State();
    if (piece_ && state.recovery != nullptr) LeavePiece();
    const FrameResult result = piece_ ? TrackInPiece(frame, state) : TrackInMap(frame, state);
    if (!piece_) handover_.OnFrame(result.is_keyframe);
    if (result.state == TrackingState::kTracking) ++tracked_frames_;
    if (result.classes == ClassState::kKnown) ++classified_frames_;
    if (result.classes == ClassState::kMissed) ++unclassified_frames_;
    return result;
  }

  void WaitForMapper(int backlog) override {
    if (piece_) piece_->mapper().WaitForBacklog(static_cast<size_t>(backlog));
    mapper_.WaitForBacklog(static_cast<size_t>(backlog));
  }

  void Finish() override {
    if (piece_) LeavePiece();
    handover_.Finish();
    mapper_.Finish();
  }

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
            unclassified_frames_ + counts.unclassified_keyframes,
            counts.joined_pieces};
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

  // A map begins, or begins anew: the next frame needs it, and no later one waits again.
  static bool StartsMap(const TrackOutput& output) {
    return output.initial_pair.has_value() || output.result.map_version == 0 || output.reset_map;
  }

  FrameResult TrackInMap(const FrameInput& frame, const MapperState& state) {
    TrackOutput output = tracker_.Track(frame, state);
    const bool starts_map = !is_stranger_ && StartsMap(output);
    if (is_stranger_ && output.result.state == TrackingState::kLost)
      output.result.failure = mapper_.counts().last_failure;
    mapper_.Push(&output);
    if (starts_map) mapper_.WaitForBacklog(0);
    return output.result;
  }

  FrameResult TrackInPiece(const FrameInput& frame, const MapperState& map) {
    MapperSeat& mapper = piece_->mapper();
    MapperState state = mapper.State();
    state.seeks = !map.recovering;
    TrackOutput output = tracker_.Track(frame, state);
    FrameResult result = output.result;
    const bool starts_map = StartsMap(output);
    const bool is_new = output.keyframe.has_value() || output.initial_pair.has_value();
    mapper.Push(&output);
    if (starts_map) mapper.WaitForBacklog(0);
    result.in_own_piece = true;
    // Of the map, none of whose versions the pose was found in.
    result.map_version = 0;
    if (result.state != TrackingState::kTracking) {
      result.state = TrackingState::kLost;
      result.failure = mapper_.counts().last_failure;
    } else if (!has_piece_) {
      has_piece_ = true;
      mapper_.NotePiece(frame.sequence);
    }
    ++frames_since_search_;
    if (output.sought &&
        (is_new || result.state == TrackingState::kLost || frames_since_search_ >= kFramesBetweenSearches)) {
      frames_since_search_ = 0;
      TrackOutput search;
      search.lost_frame = std::move(output.sought);
      mapper_.Push(&search);
    }
    return result;
  }

  // The vehicle is found, or its drive is over.
  void LeavePiece() {
    handover_.Begin(*std::exchange(piece_, std::nullopt));
    tracker_.ChangeMap(ids_);
  }

  Tracker tracker_;
  MapperSeat mapper_;
  const std::shared_ptr<KeyFrameIdSource> ids_;
  // The map was there before: no frame waits for it to begin.
  const bool is_stranger_;
  // In a map that others made: what the vehicle maps until it is found there; and what becomes of that.
  std::optional<OwnPiece> piece_;
  PieceHandover handover_;
  bool has_piece_ = false;
  int frames_since_search_ = 0;
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
  return std::make_unique<SlamSession>(config, rig, sink, config.deterministic ? nullptr : executor,
                                       std::move(vocabulary), std::move(segmentation), start.shared);
}

}  // namespace semmap
