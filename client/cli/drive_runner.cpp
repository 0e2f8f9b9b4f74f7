#include "client/cli/drive_runner.h"

#include <thread>

#include "client/cli/frame_message.h"
#include "client/cli/interrupt.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kAnswerTimeout{60'000};
constexpr std::chrono::milliseconds kSleepSlice{100};

double SecondsBetween(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

class Player {
 public:
  Player(FrameSource& source, Drive& drive, DriveMonitor& monitor, const PlayOptions& options,
         const Console& console)
      : source_(source), drive_(drive), monitor_(monitor), options_(options), line_(console) {}

  absl::StatusOr<PlayResult> Play() {
    const absl::Status sent = SendAll();
    absl::Status answered = sent;
    if (sent.ok()) answered = drive_.WaitForAnswers(kAnswerTimeout);
    const auto done = Clock::now();
    if (first_sent_) result_.duration_s = SecondsBetween(*first_sent_, done);
    // Also after a failure of the source: the server shall keep what it has. A drive that is over refuses.
    absl::StatusOr<v1::SessionSummary> summary = drive_.Finish();
    // Not before: the last answer may still be on its way to the monitor when the wait for answers is over.
    line_.Close(Progress());
    SEMMAP_RETURN_IF_ERROR(sent);
    SEMMAP_RETURN_IF_ERROR(answered);
    SEMMAP_ASSIGN_OR_RETURN(result_.summary, std::move(summary));
    result_.finish_s = SecondsBetween(done, Clock::now());
    return result_;
  }

 private:
  absl::Status SendAll() {
    while (options_.max_frames == 0 || result_.frames < options_.max_frames) {
      result_.interrupted = Interrupted();
      if (result_.interrupted) break;
      SEMMAP_ASSIGN_OR_RETURN(std::optional<SourceFrame> frame, source_.Next());
      if (!frame) break;
      SEMMAP_RETURN_IF_ERROR(SendOne(std::move(*frame)));
    }
    return absl::OkStatus();
  }

  absl::Status SendOne(SourceFrame frame) {
    const uint64_t sequence = SequenceToSend(frame);
    const TimestampNs timestamp = frame.timestamp;
    SEMMAP_ASSIGN_OR_RETURN(v1::Frame message, FrameMessage(std::move(frame)));
    if (options_.pace == Pace::kRealtime) WaitUntilDue(timestamp);
    if (!first_sent_) first_sent_ = Clock::now();
    monitor_.NoteSent(sequence);
    SEMMAP_RETURN_IF_ERROR(drive_.Send(std::move(message)));
    ++result_.frames;
    result_.last_sequence = sequence;
    if (options_.pace == Pace::kOnAnswer) SEMMAP_RETURN_IF_ERROR(drive_.WaitForAnswers(kAnswerTimeout));
    line_.Update(Progress(), Clock::now());
    return absl::OkStatus();
  }

  // In slices, so that an interrupt is heard.
  void WaitUntilDue(TimestampNs timestamp) {
    if (!first_timestamp_) {
      first_timestamp_ = timestamp;
      start_ = Clock::now();
    }
    const auto due = start_ + std::chrono::nanoseconds(timestamp - *first_timestamp_);
    while (!Interrupted() && Clock::now() < due) {
      std::this_thread::sleep_until(std::min<Clock::time_point>(due, Clock::now() + kSleepSlice));
    }
  }

  DriveProgress Progress() const {
    DriveProgress progress = monitor_.Progress();
    const std::optional<size_t> count = source_.frame_count();
    if (count) progress.total = *count;
    if (options_.max_frames != 0)
      progress.total = std::min(options_.max_frames, progress.total.value_or(UINT64_MAX));
    return progress;
  }

  FrameSource& source_;
  Drive& drive_;
  DriveMonitor& monitor_;
  const PlayOptions& options_;
  ProgressLine line_;
  PlayResult result_;
  std::optional<Clock::time_point> first_sent_;
  std::optional<TimestampNs> first_timestamp_;
  Clock::time_point start_;
};

}  // namespace

absl::StatusOr<PlayResult> Play(FrameSource& source, Drive& drive, DriveMonitor& monitor,
                                const PlayOptions& options, const Console& console) {
  return Player(source, drive, monitor, options, console).Play();
}

}  // namespace semmap::client
