#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "slam/common/mutex.h"
#include "slam/map/map_delta.h"
#include "slam/pipeline/correction_log.h"
#include "slam/pipeline/executor.h"
#include "slam/pipeline/session_mapper.h"
#include "slam/pipeline/tracker.h"

namespace semmap {

// Stands between a session's tracker and its mapper: the tracker leaves keyframes, frame poses and lost
// frames here and reads the newest view, without ever waiting for the mapper; the mapper works them off in
// order on the executor, or, without one, at once in the caller's thread. After a loop the whole map is
// adjusted as a long task beside the steps; a newer loop interrupts it and its result is dropped.
// Thread-safe.
class MapperQueue {
 public:
  // `executor` null: everything runs inside Push. `sink` receives a delta after each step.
  MapperQueue(const SlamConfig& config, const MappingCamera& camera, const ScalePyramidInfo& scale_info,
              std::shared_ptr<const Vocabulary> vocabulary, MapDeltaSink* sink, Executor* executor);
  // Waits for the work under way; what is queued is dropped.
  ~MapperQueue();

  // Before anything else: goes on in a stored map. The tracker sees nothing of it until a lost frame was
  // found there.
  void Adopt(Map map);

  MapperState State() const;
  // Takes over what the tracker wants done for a frame.
  void Push(TrackOutput* output);
  // Returns once at most `backlog` steps are waiting or under way; for 0 also once the whole map is adjusted.
  void WaitForBacklog(size_t backlog);
  // Waits for all steps and delivers the remaining frame poses.
  void Finish();

  struct Counts {
    int keyframes = 0;
    int points = 0;
    double map_ms = 0;
    int loops = 0;
    int recoveries = 0;
    int failed_recoveries = 0;
    // Of the last recovery that was tried.
    LocalizationFailure last_failure = LocalizationFailure::kNone;
    // Of keyframes that came without classes and were to get them here.
    uint64_t classified_keyframes = 0;
    uint64_t unclassified_keyframes = 0;
  };
  Counts counts() const;

 private:
  // The whole map being adjusted beside the steps.
  struct FullAdjustment {
    std::shared_ptr<FullBundle> bundle;
    std::atomic<bool> stop = false;
  };
  struct ResetStep {};
  struct RecoverStep {
    LostFrame lost;
  };
  struct ApplyStep {
    std::shared_ptr<FullAdjustment> adjustment;
  };
  using Step = std::variant<KeyFrameCandidate, InitialPair, ResetStep, RecoverStep, ApplyStep>;

  void Enqueue(Step step);
  void Drain();
  void Run(const Step& step);
  KeyFrameCandidate WithClasses(KeyFrameCandidate candidate);
  void Run(const KeyFrameCandidate& candidate);
  void Run(const InitialPair& pair);
  void Run(const ResetStep& reset);
  void Run(const RecoverStep& recover);
  void Run(const ApplyStep& apply);
  void CloseLoop();
  void StartFullAdjustment();
  enum class Reach { kLocal, kWholeMap };
  void Deliver(uint64_t up_to_sequence, Reach reach = Reach::kLocal);
  std::vector<FramePose> TakeFrames(uint64_t up_to_sequence);
  bool Resolve(FramePose* frame) const;
  size_t Backlog() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return steps_.size() + (running_ ? 1 : 0); }

  const LoopConfig loop_config_;
  MapDeltaSink* const sink_;
  Executor* const executor_;
  const size_t capacity_;
  bool map_is_stored_ = false;
  // Touched by the running step only.
  SessionMapper mapper_;
  uint64_t delta_version_ = 0;
  CorrectionLog corrections_;
  // True while another keyframe waits: the running step should hurry.
  std::atomic<bool> hurry_ = false;

  mutable Mutex mutex_;  // guards what tracker, mapper and long tasks exchange
  std::deque<Step> steps_ ABSL_GUARDED_BY(mutex_);
  bool running_ ABSL_GUARDED_BY(mutex_) = false;
  bool closing_ ABSL_GUARDED_BY(mutex_) = false;
  // The newest full adjustment, and how many long tasks have not ended.
  std::shared_ptr<FullAdjustment> adjustment_ ABSL_GUARDED_BY(mutex_);
  int adjusting_ ABSL_GUARDED_BY(mutex_) = 0;
  bool recovering_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<const Recovery> recovery_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<const LocalMapView> view_ ABSL_GUARDED_BY(mutex_);
  std::deque<FramePose> frames_ ABSL_GUARDED_BY(mutex_);
  Counts counts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap
