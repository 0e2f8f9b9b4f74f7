#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/console.h"
#include "client/cli/drive_monitor.h"
#include "client/drive.h"
#include "client/sources/frame_source.h"

namespace semmap::client {

// How the frames of a source are sent.
enum class Pace {
  kOnAnswer,   // the next frame when the one before was answered: latency is that of one frame
  kPipelined,  // as credit allows
  kRealtime,   // at the recorded times
};

struct PlayOptions {
  Pace pace = Pace::kOnAnswer;
  uint64_t max_frames = 0;  // 0: all
};

// What came of it.
struct PlayResult {
  v1::SessionSummary summary;
  uint64_t frames = 0;    // sent
  double duration_s = 0;  // from the first frame to the last answer
  double finish_s = 0;    // from there until everything was stored
  bool interrupted = false;
  // Of the last frame sent.
  uint64_t last_sequence = 0;
};

// Plays a source through a drive and ends the session, also when the source fails or the user interrupts.
absl::StatusOr<PlayResult> Play(FrameSource& source, Drive& drive, DriveMonitor& monitor,
                                const PlayOptions& options, const Console& console);

}  // namespace semmap::client
