#include "slam/pipeline/mapper_queue.h"

#include <limits>
#include <unordered_map>

#include <spdlog/spdlog.h>

#include "slam/pipeline/stopwatch.h"

namespace semmap {
namespace {

// Frames that wait for their keyframe keep their distance to it in its new unit.
void Rescale(const std::vector<KeyFramePose>& moved, std::deque<FramePose>* frames) {
  std::unordered_map<KeyFrameId, double, IdHash> factors;
  for (const KeyFramePose& keyframe : moved) {
    if (keyframe.rescale != 1) factors.emplace(keyframe.id, keyframe.rescale);
  }
  if (factors.empty()) return;
  for (FramePose& frame : *frames) {
    const auto factor = factors.find(frame.reference_keyframe);
    if (factor == factors.end()) continue;
    const SE3& pose = frame.keyframe_from_camera;
    frame.keyframe_from_camera = SE3(pose.rotation(), factor->second * pose.translation());
  }
}

}  // namespace

MapperQueue::MapperQueue(const SlamConfig& config, const MappingCamera& camera,
                         const ScalePyramidInfo& scale_info, std::shared_ptr<const Vocabulary> vocabulary,
                         MapDeltaSink* sink, Executor* executor)
    : loop_config_(config.loop),
      sink_(sink),
      executor_(executor),
      capacity_(static_cast<size_t>(config.mapping.queue)),
      mapper_(config, camera, scale_info, std::move(vocabulary),
              [this](std::shared_ptr<const LocalMapView> view) {
                MutexLock lock(&mutex_);
                view_ = std::move(view);
              }) {}

MapperQueue::~MapperQueue() {
  MutexLock lock(&mutex_);
  closing_ = true;
  steps_.clear();
  hurry_ = true;
  if (adjustment_) adjustment_->stop = true;
  const auto stopped = [this]()
                           ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !running_ && adjusting_ == 0; };
  mutex_.Await(stopped);
}

void MapperQueue::Adopt(Map map) {
  map_is_stored_ = true;
  mapper_.Adopt(std::move(map));
  MutexLock lock(&mutex_);
  counts_.keyframes = static_cast<int>(mapper_.map().keyframes().size());
  counts_.points = static_cast<int>(mapper_.map().points().size());
}

MapperState MapperQueue::State() const {
  MutexLock lock(&mutex_);
  return {view_, map_is_stored_, Backlog() == 0, steps_.size() < capacity_, recovering_, recovery_};
}

void MapperQueue::Push(TrackOutput* output) {
  if (output->frame_pose) {
    MutexLock lock(&mutex_);
    if (output->initial_pair) {
      // The first frame of the pair was not answered, but the map knows its pose now.
      const KeyFrameCandidate& first = output->initial_pair->first;
      frames_.push_back({first.sequence, first.timestamp, first.id, SE3()});
    }
    frames_.push_back(*output->frame_pose);
  }
  if (output->reset_map) Enqueue(ResetStep());
  if (output->initial_pair) Enqueue(std::move(*output->initial_pair));
  if (output->keyframe) Enqueue(std::move(*output->keyframe));
  if (output->lost_frame) {
    {
      MutexLock lock(&mutex_);
      recovering_ = true;
    }
    Enqueue(RecoverStep{std::move(*output->lost_frame)});
  }
}

void MapperQueue::Enqueue(Step step) {
  if (executor_ == nullptr) {
    Run(step);
    return;
  }
  MutexLock lock(&mutex_);
  if (closing_) return;
  steps_.push_back(std::move(step));
  hurry_ = true;
  if (running_) return;
  running_ = true;
  executor_->Schedule([this] { Drain(); });
}

void MapperQueue::Drain() {
  while (true) {
    Step step;
    {
      MutexLock lock(&mutex_);
      if (steps_.empty()) {
        running_ = false;
        return;
      }
      step = std::move(steps_.front());
      steps_.pop_front();
      hurry_ = !steps_.empty();
    }
    Run(step);
  }
}

void MapperQueue::Run(const Step& step) {
  Stopwatch stopwatch;
  std::visit([this](const auto& content) { Run(content); }, step);
  MutexLock lock(&mutex_);
  counts_.keyframes = static_cast<int>(mapper_.map().keyframes().size());
  counts_.points = static_cast<int>(mapper_.map().points().size());
  counts_.map_ms += stopwatch.LapMs();
}

// The tracker still reads the features, and the map must never see them without their classes.
KeyFrameCandidate MapperQueue::WithClasses(KeyFrameCandidate candidate) {
  auto features = std::make_shared<FrameFeatures>(*candidate.features);
  const bool filled = candidate.pending_classes->Fill(features.get());
  if (filled) candidate.features = std::move(features);
  candidate.pending_classes.reset();
  MutexLock lock(&mutex_);
  ++(filled ? counts_.classified_keyframes : counts_.unclassified_keyframes);
  return candidate;
}

void MapperQueue::Run(const KeyFrameCandidate& candidate) {
  if (candidate.pending_classes != nullptr) {
    mapper_.AddKeyFrame(WithClasses(candidate), &hurry_);
  } else {
    mapper_.AddKeyFrame(candidate, &hurry_);
  }
  Deliver(candidate.sequence);
  CloseLoop();
}

void MapperQueue::Run(const InitialPair& pair) {
  mapper_.AddInitialPair(pair);
  Deliver(pair.second.sequence);
}

void MapperQueue::Run(const ResetStep& /*reset*/) {
  mapper_.Reset();
  {
    MutexLock lock(&mutex_);
    frames_.clear();
  }
  Deliver(0);
}

void MapperQueue::Run(const RecoverStep& recover) {
  const TrackedFrame& frame = recover.lost.frame;
  SessionMapper::RecoveryReport report = mapper_.Recover(recover.lost);
  MutexLock lock(&mutex_);
  recovering_ = false;
  counts_.last_failure = report.failure;
  if (report.recovery == nullptr) {
    ++counts_.failed_recoveries;
    return;
  }
  ++counts_.recoveries;
  recovery_ = std::move(report.recovery);
  // The vehicle was told that this frame is lost, but the trajectory need not have the gap.
  if (!frames_.empty() && frames_.back().sequence >= frame.sequence) return;
  const KeyFrame& reference = *mapper_.map().FindKeyFrame(recovery_->reference);
  frames_.push_back({frame.sequence, frame.timestamp, reference.id,
                     reference.camera_from_map * recovery_->frame.camera_from_map.Inverse()});
}

// A delta of its own: what was removed before was removed in the old units.
void MapperQueue::CloseLoop() {
  const auto closed = mapper_.CloseLoop();
  if (!closed) return;
  spdlog::info(
      "loop closed: keyframe {} is at {}, {} and {} inliers, moved {:.2f}, scale {:.4f}, {} points fused",
      closed->loop.current.value(), closed->loop.old.value(), closed->loop.inliers,
      closed->loop.reverse_inliers, closed->correction.shift, closed->correction.scale,
      closed->correction.fused_points);
  Deliver(0, Reach::kWholeMap);
  {
    MutexLock lock(&mutex_);
    ++counts_.loops;
  }
  if (loop_config_.full_adjustment) StartFullAdjustment();
}

void MapperQueue::StartFullAdjustment() {
  auto adjustment = std::make_shared<FullAdjustment>();
  adjustment->bundle = mapper_.PrepareFullBundle();
  if (executor_ == nullptr) {
    adjustment->bundle->Solve(nullptr);
    Run(ApplyStep{std::move(adjustment)});
    return;
  }
  MutexLock lock(&mutex_);
  if (adjustment_) adjustment_->stop = true;
  adjustment_ = adjustment;
  ++adjusting_;
  executor_->ScheduleLong([this, adjustment] {
    adjustment->bundle->Solve(&adjustment->stop);
    if (!adjustment->stop) Enqueue(ApplyStep{adjustment});
    MutexLock finished(&mutex_);
    --adjusting_;
  });
}

void MapperQueue::Run(const ApplyStep& apply) {
  // A newer loop may have come after it was solved.
  if (apply.adjustment->stop) return;
  mapper_.Apply(*apply.adjustment->bundle);
  Deliver(0, Reach::kWholeMap);
  MutexLock lock(&mutex_);
  if (adjustment_ == apply.adjustment) adjustment_.reset();
}

void MapperQueue::Deliver(uint64_t up_to_sequence, Reach reach) {
  MapDelta delta = mapper_.TakeDelta();
  {
    MutexLock lock(&mutex_);
    Rescale(delta.moved_keyframes, &frames_);
  }
  delta.frames = TakeFrames(up_to_sequence);
  if (delta.empty()) return;
  corrections_.Note(delta);
  if (reach == Reach::kWholeMap) {
    delta.corrections = corrections_.Corrections();
    delta.corrected_map_version = mapper_.view_version();
  }
  delta.version = ++delta_version_;
  sink_->OnDelta(std::move(delta));
}

std::vector<FramePose> MapperQueue::TakeFrames(uint64_t up_to_sequence) {
  std::vector<FramePose> taken;
  MutexLock lock(&mutex_);
  while (!frames_.empty() && frames_.front().sequence <= up_to_sequence) {
    if (Resolve(&frames_.front())) taken.push_back(frames_.front());
    frames_.pop_front();
  }
  return taken;
}

bool MapperQueue::Resolve(FramePose* frame) const {
  while (mapper_.map().FindKeyFrame(frame->reference_keyframe) == nullptr) {
    const auto heir = mapper_.map().FindHeir(frame->reference_keyframe);
    if (!heir) return false;
    frame->keyframe_from_camera = heir->heir_from_removed * frame->keyframe_from_camera;
    frame->reference_keyframe = heir->heir;
  }
  return true;
}

void MapperQueue::WaitForBacklog(size_t backlog) {
  MutexLock lock(&mutex_);
  const auto done = [this, backlog]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return Backlog() <= backlog && (backlog > 0 || adjusting_ == 0);
  };
  mutex_.Await(done);
}

void MapperQueue::Finish() {
  WaitForBacklog(0);
  Deliver(std::numeric_limits<uint64_t>::max());
}

MapperQueue::Counts MapperQueue::counts() const {
  MutexLock lock(&mutex_);
  return counts_;
}

}  // namespace semmap
