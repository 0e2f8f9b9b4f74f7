#pragma once

#include <chrono>
#include <map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "client/cli/progress.h"
#include "client/cli/session_trajectory.h"
#include "client/drive.h"
#include "slam/common/mutex.h"

namespace semmap::client {

// Follows a drive from outside: when frames left, when and how they were answered. Thread-safe (the answers
// come on a thread of the library).
class DriveMonitor {
 public:
  using Clock = std::chrono::steady_clock;

  struct Latencies {
    std::vector<double> answer_ms;  // from Send to the answer, for each frame
    std::vector<double> track_ms;   // tracking alone, as the server measured it
  };

  // To be given to Drive::Start; the monitor must live longer than the drive.
  DriveObserver Observer();

  void NoteSent(uint64_t sequence);
  DriveProgress Progress() const;
  Latencies latencies() const;
  // Poses as they were answered.
  SequencedPoses online_poses() const;

 private:
  void OnEstimate(const v1::FrameEstimate& estimate);
  void OnDropped(const v1::FramesDropped& dropped);

  mutable Mutex mutex_;
  std::map<uint64_t, Clock::time_point> in_flight_ ABSL_GUARDED_BY(mutex_);
  std::optional<Clock::time_point> first_sent_ ABSL_GUARDED_BY(mutex_);
  DriveProgress progress_ ABSL_GUARDED_BY(mutex_);
  Latencies latencies_ ABSL_GUARDED_BY(mutex_);
  SequencedPoses online_poses_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::client
