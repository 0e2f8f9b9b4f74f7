#include "slam/pipeline/tracker.h"

#include <algorithm>

#include "slam/pipeline/keyframe_policy.h"
#include "slam/pipeline/stopwatch.h"

namespace semmap {
namespace {

// A map this young is thrown away when the track is lost: starting over costs less than a bad start. With
// depth there is no bad start, so it is kept until the vehicle must have left it.
constexpr int kDisposableKeyFrames = 5;
constexpr double kKeepYoungMapSeconds = 5;
constexpr int kMinInitialDepthPoints = 100;
// Established: seen by two keyframes, as every triangulated point is once; what one of them lost again does
// not count.
constexpr uint32_t kEstablishedViews = 2;
// Doubt that was unfounded is not raised again for so many frames.
constexpr int kFramesBetweenDoubts = 10;

KeyFrameCandidate ToCandidate(KeyFrameId id, const TrackedFrame& frame) {
  KeyFrameCandidate candidate;
  candidate.id = id;
  candidate.sequence = frame.sequence;
  candidate.timestamp = frame.timestamp;
  candidate.features = frame.features;
  candidate.grid = frame.grid;
  candidate.camera_from_reference = frame.camera_from_map;
  candidate.points.assign(frame.features->size(), MapPointId());
  return candidate;
}

}  // namespace

Tracker::Tracker(const SlamConfig& config, const CameraRig& rig,
                 std::shared_ptr<SegmentationQueue> segmentation)
    : config_(config),
      builder_(config, rig, std::move(segmentation)),
      camera_(MakeMappingCamera(config, builder_)),
      monocular_initializer_(builder_.rig().camera, static_cast<uint32_t>(config.seed), config.semantics),
      inactive_(config.semantics.InactiveClasses()) {
  search_.association = camera_.association;
  search_.model = builder_.model();
  search_.bounds = builder_.bounds();
  search_.scale_info = &builder_.scale_info();
  search_.near_depth = camera_.near_depth;
}

TrackOutput Tracker::Track(const FrameInput& input, const MapperState& mapper) {
  Stopwatch total;
  times_ = StageTimes();
  TrackOutput output;
  output.result.sequence = input.sequence;
  output.result.timestamp = input.timestamp;
  const bool classify = ClassifiesNow();
  TrackedFrame frame = builder_.Build(input, classify, &times_);
  const bool is_classified = frame.is_classified;
  if (mapper.seeks) output.sought = {frame, {}};
  AdoptView(mapper.view);
  AdoptRecovery(mapper.recovery.get());
  if (view_ == nullptr && mapper.map_is_strange) {
    HandleLoss(frame, mapper, &output);
  } else if (view_ == nullptr) {
    Initialize(std::move(frame), &output);
  } else {
    TrackInMap(std::move(frame), mapper, &output);
  }
  output.result.classes = SettleClasses(input, is_classified, classify, &output);
  output.result.state = state_;
  output.result.map_version = view_ ? view_->version : 0;
  times_.total_ms = total.LapMs();
  output.result.times = times_;
  return output;
}

// --- classes

bool Tracker::ClassifiesNow() const {
  if (!builder_.can_segment()) return false;
  return config_.segmentation.mode == SegmentationMode::kEveryFrame || state_ == TrackingState::kInitializing;
}

ClassState Tracker::SettleClasses(const FrameInput& input, bool is_classified, bool was_asked,
                                  TrackOutput* output) {
  if (is_classified) return ClassState::kKnown;
  if (output->keyframe) {
    output->keyframe->pending_classes = builder_.ClassifyLater(input);
    if (output->keyframe->pending_classes != nullptr) return ClassState::kPending;
  }
  return was_asked ? ClassState::kMissed : ClassState::kNotWanted;
}

// A keypoint that nobody looked at is what its point is; without confidence it is no vote for it.
void Tracker::CarryClasses(TrackedFrame* frame) const {
  for (size_t i = 0; i < matches_.size(); ++i) {
    if (matches_[i] < 0) continue;
    Keypoint& keypoint = frame->features->keypoints[i];
    keypoint.semantic_class = view_->classes[static_cast<size_t>(matches_[i])];
    keypoint.class_confidence = 0;
  }
}

// --- the map as the tracker sees it

void Tracker::AdoptView(std::shared_ptr<const LocalMapView> view) {
  if (view == view_) return;
  if (view_) ReportSightings(*view_);
  view_ = std::move(view);
  if (!view_) {
    last_.reset();
    return;
  }
  counters_.visible.assign(view_->size(), 0);
  counters_.found.assign(view_->size(), 0);
  RefreshLastPose();
}

void Tracker::ChangeMap(std::shared_ptr<KeyFrameIdSource> ids) {
  ids_ = std::move(ids);
  state_ = TrackingState::kLost;
  view_.reset();
  last_.reset();
  last_keyframe_ = KeyFrameId();
  velocity_.reset();
  sightings_.clear();
  recovered_sequence_ = 0;
  monocular_initializer_.Reset();
}

void Tracker::ReportSightings(const LocalMapView& old_view) {
  for (size_t i = 0; i < counters_.visible.size(); ++i) {
    if (counters_.visible[i] > 0)
      sightings_.push_back({old_view.ids[i], counters_.visible[i], counters_.found[i]});
  }
}

void Tracker::RefreshLastPose() {
  if (!last_) return;
  if (const ViewKeyFrame* own = view_->FindKeyFrame(last_keyframe_); own != nullptr) {
    last_->camera_from_map = own->camera_from_map;
  } else if (const ViewKeyFrame* reference = view_->FindKeyFrame(last_reference_); reference != nullptr) {
    last_->camera_from_map = last_camera_from_reference_ * reference->camera_from_map;
  }
}

// The next frame is tracked from the one that was found, as if it had never been lost.
void Tracker::AdoptRecovery(const Recovery* recovery) {
  // While tracking, only what was asked for in doubt comes, and only if it is better.
  if (state_ == TrackingState::kInitializing || recovery == nullptr || view_ == nullptr ||
      recovery->frame.sequence <= recovered_sequence_) {
    return;
  }
  recovered_sequence_ = recovery->frame.sequence;
  last_ = recovery->frame;
  last_points_ = recovery->points;
  last_keyframe_ = KeyFrameId();
  last_reference_ = view_->reference().id;
  last_camera_from_reference_ = last_->camera_from_map * view_->reference().camera_from_map.Inverse();
  velocity_.reset();
  state_ = TrackingState::kTracking;
}

// --- no map yet

void Tracker::Initialize(TrackedFrame frame, TrackOutput* output) {
  state_ = TrackingState::kInitializing;
  velocity_.reset();
  if (builder_.rig().sensor == SensorType::kMono) {
    InitializeMonocular(std::move(frame), output);
  } else {
    InitializeWithDepth(std::move(frame), output);
  }
}

void Tracker::InitializeWithDepth(TrackedFrame frame, TrackOutput* output) {
  const auto with_depth = std::count_if(frame.features->keypoints.begin(), frame.features->keypoints.end(),
                                        [&](const Keypoint& k) { return MeasuresDepth(k); });
  if (with_depth < kMinInitialDepthPoints) return;
  const KeyFrameId id = ids_->Next();
  output->keyframe = ToCandidate(id, frame);
  output->result.map_from_camera = SE3();
  output->result.inliers = static_cast<int>(with_depth);
  output->result.is_keyframe = true;
  output->frame_pose = FramePose{frame.sequence, frame.timestamp, id, SE3()};
  state_ = TrackingState::kTracking;
  last_keyframe_ = id;
  last_keyframe_time_ = frame.timestamp;
  last_reference_ = KeyFrameId();
  last_points_.assign(frame.features->size(), MapPointId());
  last_ = std::move(frame);
}

void Tracker::InitializeMonocular(TrackedFrame frame, TrackOutput* output) {
  auto reconstruction = monocular_initializer_.Add(frame);
  if (!reconstruction) return;
  monocular_initializer_.Reset();
  InitialPair pair;
  const KeyFrameId first_id = ids_->Next();
  const KeyFrameId second_id = ids_->Next();
  pair.first = ToCandidate(first_id, reconstruction->first);
  pair.first.camera_from_reference = SE3();
  frame.camera_from_map = reconstruction->second_from_first;
  pair.second = ToCandidate(second_id, frame);
  for (const auto& point : reconstruction->points) {
    pair.points.push_back({point.position_in_first, static_cast<uint32_t>(point.keypoint_in_first),
                           static_cast<uint32_t>(point.keypoint_in_second)});
  }
  output->result.map_from_camera = frame.camera_from_map.Inverse();
  output->result.inliers = static_cast<int>(pair.points.size());
  output->result.is_keyframe = true;
  output->frame_pose = FramePose{frame.sequence, frame.timestamp, second_id, SE3()};
  output->initial_pair = std::move(pair);
  state_ = TrackingState::kTracking;
  last_keyframe_ = second_id;
  last_keyframe_time_ = frame.timestamp;
  last_reference_ = first_id;
  last_camera_from_reference_ = frame.camera_from_map;
  last_points_.assign(frame.features->size(), MapPointId());
  last_ = std::move(frame);
}

// --- tracking

void Tracker::TrackInMap(TrackedFrame frame, const MapperState& mapper, TrackOutput* output) {
  const bool was_lost = state_ == TrackingState::kLost;
  matches_.assign(frame.features->size(), -1);
  depth_matches_.assign(frame.features->size(), std::nullopt);
  if (!Locate(&frame, &output->result)) {
    HandleLoss(frame, mapper, output);
    return;
  }
  state_ = TrackingState::kTracking;
  CountSightings();
  if (builder_.can_segment() && !frame.is_classified) CarryClasses(&frame);
  // After a loss or a leap the first good frame says nothing about velocity.
  velocity_.reset();
  if (last_ && !was_lost && !relocalized_)
    velocity_ = frame.camera_from_map * last_->camera_from_map.Inverse();
  const ViewKeyFrame& reference = view_->reference();
  output->result.map_from_camera = frame.camera_from_map.Inverse();
  FramePose pose{frame.sequence, frame.timestamp, reference.id,
                 reference.camera_from_map * frame.camera_from_map.Inverse()};
  last_keyframe_ = KeyFrameId();
  AskIfDoubtful(frame, mapper, output);
  // A keyframe at a wrong place would spoil the map.
  const bool trusted = !IsDoubtful(agreement_) || !mapper.recovering;
  if (trusted && !output->lost_frame &&
      IsKeyFrameNeeded(config_.tracking, GatherEvidence(frame, mapper, output->result.inliers))) {
    output->keyframe = MakeCandidate(frame);
    output->result.is_keyframe = true;
    last_keyframe_ = output->keyframe->id;
    last_keyframe_time_ = frame.timestamp;
    pose.reference_keyframe = last_keyframe_;
    pose.keyframe_from_camera = SE3();
  }
  output->frame_pose = pose;
  Remember(std::move(frame));
}

void Tracker::HandleLoss(const TrackedFrame& frame, const MapperState& mapper, TrackOutput* output) {
  state_ = TrackingState::kLost;
  velocity_.reset();
  output->result.inliers = 0;
  if (mapper.map_is_strange || !IsMapDisposable(frame)) {
    if (!mapper.recovering) output->lost_frame = {frame, {}};
    return;
  }
  if (!mapper.idle) return;
  output->reset_map = true;
  state_ = TrackingState::kInitializing;
  view_.reset();
  last_.reset();
  sightings_.clear();
  monocular_initializer_.Reset();
  if (builder_.rig().sensor == SensorType::kMono) monocular_initializer_.Add(frame);
}

bool Tracker::IsMapDisposable(const TrackedFrame& frame) const {
  if (view_->map_keyframes > kDisposableKeyFrames) return false;
  return !camera_.HasDepth() || !last_ ||
         ToSeconds(frame.timestamp - last_->timestamp) > kKeepYoungMapSeconds;
}

// Much of what should be in sight is not found: perhaps the vehicle is somewhere else, where more would be.
void Tracker::AskIfDoubtful(const TrackedFrame& frame, const MapperState& mapper, TrackOutput* output) {
  if (!IsDoubtful(agreement_)) {
    frames_since_asked_ = kFramesBetweenDoubts;
    return;
  }
  if (mapper.recovering || frames_since_asked_++ < kFramesBetweenDoubts) return;
  frames_since_asked_ = 0;
  output->lost_frame = {frame, agreement_};
}

void Tracker::Remember(TrackedFrame frame) {
  last_points_.assign(frame.features->size(), MapPointId());
  for (size_t i = 0; i < matches_.size(); ++i) {
    if (matches_[i] >= 0) last_points_[i] = view_->ids[matches_[i]];
  }
  last_reference_ = view_->reference().id;
  last_camera_from_reference_ = frame.camera_from_map * view_->reference().camera_from_map.Inverse();
  last_ = std::move(frame);
}

void Tracker::CountSightings() {
  for (const int32_t match : matches_) {
    if (match >= 0) ++counters_.found[match];
  }
}

// --- keyframes

KeyFrameEvidence Tracker::GatherEvidence(const TrackedFrame& frame, const MapperState& mapper,
                                         int inliers) const {
  KeyFrameEvidence evidence;
  evidence.sensor = builder_.rig().sensor;
  evidence.inliers = inliers;
  evidence.map_keyframes = view_->map_keyframes;
  evidence.seconds_since_keyframe = ToSeconds(frame.timestamp - last_keyframe_time_);
  evidence.mapper_idle = mapper.idle;
  evidence.mapper_accepts = mapper.accepts_keyframe;
  // A point with depth needs no second view to be good.
  const uint32_t established = evidence.sensor != SensorType::kMono
                                   ? 1
                                   : std::min(kEstablishedViews, static_cast<uint32_t>(view_->map_keyframes));
  for (const int32_t point : view_->reference().point_of_keypoint) {
    if (point >= 0 && view_->observation_counts[point] >= established) ++evidence.reference_points;
  }
  for (size_t i = 0; i < matches_.size(); ++i) {
    const Keypoint& keypoint = frame.features->keypoints[i];
    if (!MeasuresDepth(keypoint) || keypoint.depth > camera_.near_depth) continue;
    ++(matches_[i] >= 0 ? evidence.close_tracked : evidence.close_untracked);
  }
  return evidence;
}

KeyFrameCandidate Tracker::MakeCandidate(const TrackedFrame& frame) {
  KeyFrameCandidate candidate = ToCandidate(ids_->Next(), frame);
  const ViewKeyFrame& reference = view_->reference();
  candidate.reference = reference.id;
  candidate.camera_from_reference = frame.camera_from_map * reference.camera_from_map.Inverse();
  for (size_t i = 0; i < matches_.size(); ++i) {
    if (matches_[i] >= 0) candidate.points[i] = view_->ids[matches_[i]];
  }
  ReportSightings(*view_);
  std::fill(counters_.visible.begin(), counters_.visible.end(), 0);
  std::fill(counters_.found.begin(), counters_.found.end(), 0);
  candidate.sightings = std::exchange(sightings_, {});
  return candidate;
}

}  // namespace semmap
