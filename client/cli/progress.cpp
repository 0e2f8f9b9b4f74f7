#include "client/cli/progress.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace semmap::client {
namespace {

constexpr uint64_t kBarWidth = 24;
constexpr std::chrono::milliseconds kTerminalInterval{150};
constexpr std::chrono::seconds kLogInterval{10};

std::string BarOf(uint64_t done, uint64_t total) {
  const uint64_t filled = total == 0 ? 0 : kBarWidth * std::min(done, total) / total;
  return absl::StrCat("[", std::string(filled, '#'), std::string(kBarWidth - filled, '.'), "] ");
}

}  // namespace

std::string FormatProgress(const DriveProgress& progress) {
  const std::string count = progress.total
                                ? absl::StrFormat("%s%d/%d", BarOf(progress.answered, *progress.total),
                                                  progress.answered, *progress.total)
                                : absl::StrFormat("%d frames", progress.answered);
  return absl::StrFormat("%s  %5.1f fps  %-12s %6.1f ms  %d keyframes", count, progress.frames_per_second,
                         progress.tracking, progress.latency_ms, progress.keyframes);
}

void ProgressLine::Update(const DriveProgress& progress, Clock::time_point now) {
  const auto interval = console_.err_is_terminal ? std::chrono::milliseconds(kTerminalInterval)
                                                 : std::chrono::milliseconds(kLogInterval);
  if (!last_shown_) last_shown_ = console_.err_is_terminal ? now - interval : now;
  if (now - *last_shown_ < interval) return;
  last_shown_ = now;
  Show(progress);
}

void ProgressLine::Close(const DriveProgress& progress) {
  Show(progress);
  if (console_.err_is_terminal) console_.err << "\n";
  console_.err.flush();
}

void ProgressLine::Show(const DriveProgress& progress) {
  std::string line = FormatProgress(progress);
  if (!console_.err_is_terminal) {
    console_.err << line << "\n";
    return;
  }
  // A shorter line must cover what the longer one before left behind.
  const size_t width = line.size();
  if (width < shown_width_) line.append(shown_width_ - width, ' ');
  shown_width_ = width;
  console_.err << "\r" << line;
  console_.err.flush();
}

}  // namespace semmap::client
