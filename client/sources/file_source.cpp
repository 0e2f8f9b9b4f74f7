#include "client/sources/file_source.h"

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/statistics.h"

namespace semmap::client {
namespace {

constexpr double kDefaultFrameRate = 10;

class FileSource : public FrameSource {
 public:
  explicit FileSource(FileRecording recording) : recording_(std::move(recording)) {}

  const CameraRig& rig() const override { return recording_.rig; }
  std::optional<size_t> frame_count() const override { return recording_.frames.size(); }
  const std::optional<Trajectory>& ground_truth() const override { return recording_.ground_truth; }

  absl::StatusOr<std::optional<SourceFrame>> Next() override {
    if (next_ == recording_.frames.size()) return std::nullopt;
    SEMMAP_ASSIGN_OR_RETURN(SourceFrame frame, ReadFrame(recording_.frames[next_], next_));
    ++next_;
    return frame;
  }

 private:
  FileRecording recording_;
  size_t next_ = 0;
};

}  // namespace

absl::StatusOr<std::unique_ptr<FrameSource>> MakeFileSource(FileRecording recording) {
  SEMMAP_RETURN_IF_ERROR(ValidateRig(recording.rig));
  if (recording.frames.empty()) return absl::InvalidArgumentError("the recording has no frames");
  for (size_t i = 1; i < recording.frames.size(); ++i) {
    if (recording.frames[i].timestamp > recording.frames[i - 1].timestamp) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(recording.frames[i].image, ": its time is not later than that of the frame before"));
  }
  return std::make_unique<FileSource>(std::move(recording));
}

absl::StatusOr<SourceFrame> ReadFrame(const FrameFiles& files, uint64_t sequence) {
  SourceFrame frame;
  frame.sequence = sequence;
  frame.timestamp = files.timestamp;
  SEMMAP_ASSIGN_OR_RETURN(frame.image, ReadSourceImage(files.image, false));
  if (!files.right.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(frame.right, ReadSourceImage(files.right, false));
  }
  if (!files.depth.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(frame.depth, ReadSourceImage(files.depth, true));
  }
  if (!files.class_mask.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(frame.class_mask, ReadSourceImage(files.class_mask, false));
  }
  return frame;
}

double FrameRateOf(const std::vector<FrameFiles>& frames) {
  std::vector<double> intervals;
  for (size_t i = 1; i < frames.size(); ++i) {
    intervals.push_back(ToSeconds(frames[i].timestamp - frames[i - 1].timestamp));
  }
  const double median = Percentile(intervals, 0.5);
  return median > 0 ? 1.0 / median : kDefaultFrameRate;
}

}  // namespace semmap::client
