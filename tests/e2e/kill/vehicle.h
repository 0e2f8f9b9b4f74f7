#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "recording.h"
#include "semmap/v1/session.pb.h"
#include "slam/common/mutex.h"

namespace semmap::kill_test {

// What a vehicle was told in its drive.
struct Testimony {
  std::string map;
  v1::SessionMode mode = v1::SESSION_MODE_MAP;
  const Recording* recording = nullptr;
  // Empty: the server died before it answered the hello.
  std::string session;
  std::string resume_token;
  uint64_t acknowledged = 0;
  std::vector<uint64_t> tracked;    // frames with a pose
  std::vector<uint64_t> keyframes;  // frames that became keyframes
  std::vector<absl::Time> answers;  // when each frame was answered
  std::optional<absl::Time> corrected;
  // OK: the drive came to its end and everything was stored.
  absl::Status end = absl::UnknownError("not over");

  // Of `tracked` or `keyframes`: what the server said was durable.
  std::vector<uint64_t> Durable(const std::vector<uint64_t>& sequences) const;
};

// Drives a recording through a session on a thread of its own, as fast as the server takes it, until the end
// or the server's death. Thread-safe.
class Vehicle {
 public:
  Vehicle(const Recording& recording, const std::string& address, const std::string& map,
          v1::SessionMode mode);
  ~Vehicle();
  Vehicle(const Vehicle&) = delete;
  Vehicle& operator=(const Vehicle&) = delete;

  // Waits until so many frames were answered or the drive is over.
  void WaitForAnswers(size_t count);
  // Waits for the end. Once.
  Testimony Finish();

 private:
  void Run(const std::string& address);
  absl::Status Drive(const std::string& address);
  bool HasAnswersOrEnded(size_t count) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return over_ || told_.answers.size() >= count;
  }

  Mutex mutex_;  // guards all below but the thread
  Testimony told_ ABSL_GUARDED_BY(mutex_);
  bool over_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace semmap::kill_test
