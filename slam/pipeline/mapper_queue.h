#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "slam/map/map_delta.h"
#include "slam/pipeline/executor.h"
#include "slam/pipeline/local_mapper.h"
#include "slam/pipeline/tracker.h"

namespace semmap {

// Stands between a session's tracker and its mapper: the tracker leaves keyframes and frame poses here and
// reads the newest view, without ever waiting for the mapper; the mapper works them off in order on the
// executor, or, without one, at once in the caller's thread. Thread-safe.
class MapperQueue {
 public:
  // `executor` null: everything runs inside Push. `sink` receives a delta after each step.
  MapperQueue(const SlamConfig& config, MappingCamera camera, ScalePyramidInfo scale_info, MapDeltaSink* sink,
              Executor* executor);
  // Waits for the work under way; what is queued is dropped.
  ~MapperQueue();

  MapperState State() const;
  // Takes over what the tracker wants done for a frame.
  void Push(TrackOutput* output);
  // Returns once at most `backlog` steps are waiting or under way.
  void WaitForBacklog(size_t backlog);
  // Waits for all steps and delivers the remaining frame poses.
  void Finish();

  struct Counts {
    int keyframes = 0;
    int points = 0;
    double map_ms = 0;
  };
  Counts counts() const;

 private:
  struct ResetStep {};
  using Step = std::variant<KeyFrameCandidate, InitialPair, ResetStep>;

  void Enqueue(Step step);
  void Drain();
  void Run(const Step& step);
  void Deliver(uint64_t up_to_sequence);
  std::vector<FramePose> TakeFrames(uint64_t up_to_sequence);
  bool Resolve(FramePose* frame) const;
  size_t Backlog() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return steps_.size() + (running_ ? 1 : 0); }

  MapDeltaSink* const sink_;
  Executor* const executor_;
  const size_t capacity_;
  // Touched by the running step only.
  LocalMapper mapper_;
  uint64_t delta_version_ = 0;
  // True while another keyframe waits: the running step should hurry.
  std::atomic<bool> hurry_ = false;

  mutable absl::Mutex mutex_;  // guards what tracker and mapper exchange
  std::deque<Step> steps_ ABSL_GUARDED_BY(mutex_);
  bool running_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<const LocalMapView> view_ ABSL_GUARDED_BY(mutex_);
  std::deque<FramePose> frames_ ABSL_GUARDED_BY(mutex_);
  Counts counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap
