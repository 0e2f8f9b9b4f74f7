#include "slam/pipeline/mapper_queue.h"

#include <limits>

#include "slam/pipeline/stopwatch.h"

namespace semmap {
namespace {

uint64_t LastSequence(const KeyFrameCandidate& candidate) { return candidate.sequence; }
uint64_t LastSequence(const InitialPair& pair) { return pair.second.sequence; }

}  // namespace

MapperQueue::MapperQueue(const SlamConfig& config, MappingCamera camera, ScalePyramidInfo scale_info,
                         MapDeltaSink* sink, Executor* executor)
    : sink_(sink),
      executor_(executor),
      capacity_(static_cast<size_t>(config.mapping.queue)),
      mapper_(config, std::move(camera), std::move(scale_info),
              [this](std::shared_ptr<const LocalMapView> view) {
                absl::MutexLock lock(&mutex_);
                view_ = std::move(view);
              }) {}

MapperQueue::~MapperQueue() {
  absl::MutexLock lock(&mutex_);
  steps_.clear();
  hurry_ = true;
  const auto stopped = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !running_; };
  mutex_.Await(absl::Condition(&stopped));
}

MapperState MapperQueue::State() const {
  absl::MutexLock lock(&mutex_);
  return {view_, Backlog() == 0, steps_.size() < capacity_};
}

void MapperQueue::Push(TrackOutput* output) {
  if (output->frame_pose) {
    absl::MutexLock lock(&mutex_);
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
}

void MapperQueue::Enqueue(Step step) {
  if (executor_ == nullptr) {
    Run(step);
    return;
  }
  absl::MutexLock lock(&mutex_);
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
      absl::MutexLock lock(&mutex_);
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
  uint64_t up_to_sequence = 0;
  if (const auto* candidate = std::get_if<KeyFrameCandidate>(&step)) {
    mapper_.AddKeyFrame(*candidate, &hurry_);
    up_to_sequence = LastSequence(*candidate);
  } else if (const auto* pair = std::get_if<InitialPair>(&step)) {
    mapper_.AddInitialPair(*pair);
    up_to_sequence = LastSequence(*pair);
  } else {
    mapper_.Reset();
    absl::MutexLock lock(&mutex_);
    frames_.clear();
  }
  Deliver(up_to_sequence);
  absl::MutexLock lock(&mutex_);
  counts_.keyframes = static_cast<int>(mapper_.map().keyframes().size());
  counts_.points = static_cast<int>(mapper_.map().points().size());
  counts_.map_ms += stopwatch.LapMs();
}

void MapperQueue::Deliver(uint64_t up_to_sequence) {
  MapDelta delta = mapper_.TakeDelta();
  delta.frames = TakeFrames(up_to_sequence);
  if (delta.empty()) return;
  delta.version = ++delta_version_;
  sink_->OnDelta(std::move(delta));
}

std::vector<FramePose> MapperQueue::TakeFrames(uint64_t up_to_sequence) {
  std::vector<FramePose> taken;
  absl::MutexLock lock(&mutex_);
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
  absl::MutexLock lock(&mutex_);
  const auto done = [this, backlog]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return Backlog() <= backlog; };
  mutex_.Await(absl::Condition(&done));
}

void MapperQueue::Finish() {
  WaitForBacklog(0);
  Deliver(std::numeric_limits<uint64_t>::max());
}

MapperQueue::Counts MapperQueue::counts() const {
  absl::MutexLock lock(&mutex_);
  return counts_;
}

}  // namespace semmap
