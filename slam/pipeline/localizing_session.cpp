#include "slam/pipeline/localizing_session.h"

#include <unordered_map>
#include <utility>

#include "slam/common/status_macros.h"
#include "slam/pipeline/stopwatch.h"

namespace semmap {
namespace {

// Frame poses are stored so many at once: a transaction for each frame would cost more than it is worth.
constexpr size_t kFramesPerDelta = 20;
// The view moves when another keyframe sees so many times what its centre sees.
constexpr double kRecenterGain = 1.1;

CameraRig RigFor(const MapSnapshot& map, CameraRig rig) {
  if (!map.scale_known()) rig.sensor = SensorType::kMono;
  return rig;
}

}  // namespace

LocalizingSession::LocalizingSession(const SlamConfig& config, const CameraRig& rig,
                                     std::shared_ptr<SegmentationQueue> segmentation,
                                     std::shared_ptr<const MapSnapshot> map, MapDeltaSink* sink)
    : map_(std::move(map)),
      sink_(sink),
      tracker_(config, RigFor(*map_, rig), std::move(segmentation)),
      localizer_(config.relocalization, static_cast<uint32_t>(config.seed)) {}

absl::StatusOr<FrameResult> LocalizingSession::Track(const FrameInput& frame) {
  SEMMAP_RETURN_IF_ERROR(order_.Check(frame));
  SEMMAP_RETURN_IF_ERROR(tracker_.Check(frame));
  order_.Take(frame);
  ++frames_;
  Stopwatch stopwatch;
  MapperState state;
  state.view = view_;
  state.map_is_strange = true;
  state.accepts_keyframe = false;
  state.recovery = recovery_;
  TrackOutput output = tracker_.Track(frame, state);
  if (output.lost_frame) {
    SEMMAP_RETURN_IF_ERROR(Search(*output.lost_frame, &output));
  } else if (output.frame_pose) {
    SEMMAP_RETURN_IF_ERROR(Recenter());
  }
  if (output.frame_pose) {
    ++tracked_frames_;
    Keep(*output.frame_pose);
  }
  output.result.map_version = view_ ? view_->version : map_->version();
  output.result.times.total_ms = stopwatch.LapMs();
  return output.result;
}

absl::Status LocalizingSession::Search(const LostFrame& lost, TrackOutput* output) {
  SEMMAP_ASSIGN_OR_RETURN(
      const MapLocalization located,
      localizer_.Locate(*map_, tracker_.camera(), {*lost.frame.features, *lost.frame.grid}, PlacePrior()));
  const bool better = located.found && lost.IsBetter(located.agreement);
  last_failure_ = located.found && !better ? LocalizationFailure::kTooFewInliers : located.failure;
  if (!better) {
    ++failed_recoveries_;
    if (output->result.state == TrackingState::kLost) output->result.failure = last_failure_;
    return absl::OkStatus();
  }
  ++recoveries_;
  SEMMAP_RETURN_IF_ERROR(Adopt(lost, *located.found));
  const ViewKeyFrame& reference = view_->reference();
  const SE3 map_from_camera = located.found->fix.camera_from_map.Inverse();
  output->frame_pose = FramePose{lost.frame.sequence, lost.frame.timestamp, reference.id,
                                 reference.camera_from_map * map_from_camera};
  output->result.state = TrackingState::kTracking;
  output->result.map_from_camera = map_from_camera;
  output->result.covariance = located.found->fix.covariance;
  output->result.inliers = located.agreement.inliers;
  return absl::OkStatus();
}

absl::Status LocalizingSession::Adopt(const LostFrame& lost, const MapFix& found) {
  auto recovery = MakeRecovery(lost.frame, *found.view, found.fix);
  // With the keyframes around, which help to track on.
  SEMMAP_ASSIGN_OR_RETURN(auto view, map_->ViewAround(recovery->reference, LocalMapViewLimits()));
  recovery_ = std::move(recovery);
  view_ = view != nullptr ? std::move(view) : found.view;
  return absl::OkStatus();
}

absl::Status LocalizingSession::Recenter() {
  std::unordered_map<KeyFrameId, int, IdHash> counts;
  for (const MapPointId id : tracker_.last_points()) {
    if (id.IsValid()) map_->ForEachObserver(id, [&](KeyFrameId observer) { ++counts[observer]; });
  }
  KeyFrameId best = view_->reference().id;
  double most = kRecenterGain * counts[best];
  for (const auto& [id, count] : counts) {
    if (count > most || (count == most && id < best)) {
      best = id;
      most = count;
    }
  }
  if (best == view_->reference().id) return absl::OkStatus();
  SEMMAP_ASSIGN_OR_RETURN(auto view, map_->ViewAround(best, LocalMapViewLimits()));
  if (view != nullptr) view_ = std::move(view);
  return absl::OkStatus();
}

void LocalizingSession::Keep(const FramePose& pose) {
  delta_.frames.push_back(pose);
  if (delta_.frames.size() >= kFramesPerDelta) Deliver();
}

void LocalizingSession::Deliver() {
  if (delta_.empty()) return;
  delta_.version = ++delta_version_;
  sink_->OnDelta(std::exchange(delta_, MapDelta()));
}

SessionStats LocalizingSession::Stats() const {
  SessionStats stats;
  stats.keyframes = static_cast<int>(map_->keyframe_count());
  stats.points = static_cast<int>(map_->point_count());
  stats.frames = frames_;
  stats.tracked_frames = tracked_frames_;
  stats.recoveries = recoveries_;
  stats.failed_recoveries = failed_recoveries_;
  stats.last_recovery_failure = last_failure_;
  return stats;
}

}  // namespace semmap
