#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "client/cli/console.h"

namespace semmap::client {

// What a running drive shows.
struct DriveProgress {
  uint64_t sent = 0;
  std::optional<uint64_t> total;
  uint64_t answered = 0;
  std::string tracking;  // "tracking", "lost", ...
  double latency_ms = 0;
  double frames_per_second = 0;
  uint64_t keyframes = 0;
};

// "[####......]  40/100   9.8 fps  tracking  23.1 ms  12 keyframes".
std::string FormatProgress(const DriveProgress& progress);

// Shows progress on the console's err: on a terminal one line that is overwritten a few times a second,
// otherwise a line now and then. Not thread-safe; time is passed in.
class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ProgressLine(const Console& console) : console_(console) {}

  void Update(const DriveProgress& progress, Clock::time_point now);
  // Shows the last state and ends the line.
  void Close(const DriveProgress& progress);

 private:
  void Show(const DriveProgress& progress);

  const Console& console_;
  std::optional<Clock::time_point> last_shown_;
  size_t shown_width_ = 0;
};

}  // namespace semmap::client
