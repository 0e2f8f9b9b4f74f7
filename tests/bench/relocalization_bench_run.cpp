#include "tests/bench/relocalization_bench_run.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/association.h"
#include "slam/pipeline/session.h"
#include "tests/bench/slam_bench_meters.h"
#include "tests/bench/slam_bench_run.h"

namespace semmap::bench {
namespace {

// The unit of one camera's map, from so many frames before a trial.
constexpr size_t kScaleFrames = 20;
// A kidnapped vehicle is carried back by so many times the distance it is carried on soon after: all of it
// mapped.
constexpr double kCarriedBack = 2.5;
constexpr int kFramesBetween = 6;
constexpr TimestampNs kFrameInterval = 50'000'000;

struct RecordedFrame {
  client::SourceFrame images;
  SE3 world_from_camera;
};

absl::StatusOr<std::vector<RecordedFrame>> ReadAll(client::FrameSource& source, int max_frames) {
  if (!source.ground_truth()) return absl::FailedPreconditionError("the recording has no ground truth");
  std::vector<RecordedFrame> frames;
  const std::vector<StampedPose>& truth = source.ground_truth()->poses;
  while (max_frames == 0 || frames.size() < static_cast<size_t>(max_frames)) {
    SEMMAP_ASSIGN_OR_RETURN(std::optional<client::SourceFrame> frame, source.Next());
    if (!frame) break;
    const auto pose = std::find_if(truth.begin(), truth.end(),
                                   [&](const StampedPose& p) { return p.timestamp == frame->timestamp; });
    if (pose == truth.end()) return absl::FailedPreconditionError("a frame has no true pose");
    frames.push_back({std::move(*frame), pose->map_from_camera});
  }
  return frames;
}

class Drive {
 public:
  Drive(const RelocalizationOptions& options, const std::vector<RecordedFrame>& frames, Session* session)
      : options_(options), frames_(frames), session_(session) {}

  // Feeds one frame of the recording; true when it was tracked.
  absl::StatusOr<bool> Show(size_t index) {
    SEMMAP_ASSIGN_OR_RETURN(FrameInput input, DecodeFrame(frames_[index].images));
    SEMMAP_ASSIGN_OR_RETURN(const FrameResult result, Feed(std::move(input)));
    if (result.state != TrackingState::kTracking) return false;
    last_ = {index, *result.map_from_camera};
    if (recent_.size() == kScaleFrames) recent_.erase(recent_.begin());
    recent_.push_back(last_);
    return true;
  }

  absl::Status ShowBlack() {
    SEMMAP_ASSIGN_OR_RETURN(FrameInput input, DecodeFrame(frames_.front().images));
    for (cv::Mat* image : {&input.image, &input.right, &input.depth}) {
      if (!image->empty()) *image = cv::Mat::zeros(image->size(), image->type());
    }
    return Feed(std::move(input)).status();
  }

  absl::StatusOr<TrialResult> Try(Ordeal ordeal, size_t at) {
    const Located before = last_;
    const double unit = MetresPerUnit();
    TrialResult trial;
    trial.ordeal = ordeal;
    if (ordeal == Ordeal::kKidnap) {
      size_t index = Back(at, kCarriedBack * options_.distance_m);
      for (int i = 0; i < kFramesBetween; ++i) SEMMAP_RETURN_IF_ERROR(Show(index++).status());
      trial.frame = Onward(index, options_.distance_m);
    } else {
      for (int i = 0; i < options_.black_frames; ++i) SEMMAP_RETURN_IF_ERROR(ShowBlack());
      trial.frame = ordeal == Ordeal::kBack ? Back(at, options_.distance_m) : at;
    }
    const size_t end = std::min(frames_.size(), trial.frame + static_cast<size_t>(options_.patience));
    for (size_t i = trial.frame; i < end; ++i) {
      SEMMAP_ASSIGN_OR_RETURN(const bool tracked, Show(i));
      if (!tracked) {
        trial.was_lost = true;
        continue;
      }
      trial.found_after = static_cast<int>(i - trial.frame) + 1;
      trial.error_m = MotionError(before, unit);
      break;
    }
    return trial;
  }

  // From here on a vehicle can be carried back and still be where it has mapped.
  size_t FirstTrial() const { return Onward(0, kCarriedBack * options_.distance_m); }
  size_t last_index() const { return last_.index; }

 private:
  struct Located {
    size_t index = 0;
    SE3 map_from_camera;
  };

  absl::StatusOr<FrameResult> Feed(FrameInput input) {
    input.sequence = ++sequence_;
    input.timestamp = static_cast<TimestampNs>(sequence_) * kFrameInterval;
    session_->WaitForMapper(options_.bench.backlog);
    return session_->Track(input);
  }

  double Distance(size_t from, size_t to) const {
    return (frames_[to].world_from_camera.translation() - frames_[from].world_from_camera.translation())
        .norm();
  }

  size_t Back(size_t from, double distance) const {
    size_t index = from;
    while (index > 0 && Distance(from, index) < distance) --index;
    return index;
  }
  size_t Onward(size_t from, double distance) const {
    size_t index = from;
    while (index + 1 < frames_.size() && Distance(from, index) < distance) ++index;
    return index;
  }

  double MetresPerUnit() const {
    const Located& first = recent_.front();
    const double units = (first.map_from_camera.translation() - last_.map_from_camera.translation()).norm();
    return units > 0 ? Distance(first.index, last_.index) / units : 1;
  }

  double MotionError(const Located& before, double unit) const {
    const SE3 truth =
        frames_[before.index].world_from_camera.Inverse() * frames_[last_.index].world_from_camera;
    const SE3 estimate = before.map_from_camera.Inverse() * last_.map_from_camera;
    return (unit * estimate.translation() - truth.translation()).norm();
  }

  const RelocalizationOptions& options_;
  const std::vector<RecordedFrame>& frames_;
  Session* session_;
  uint64_t sequence_ = 0;
  Located last_;
  std::vector<Located> recent_;
};

absl::StatusOr<std::vector<TrialResult>> RunOrdeal(const RelocalizationOptions& options, Ordeal ordeal,
                                                   const std::vector<RecordedFrame>& frames,
                                                   const CameraRig& rig,
                                                   const std::shared_ptr<const Vocabulary>& vocabulary) {
  MeasuringSink sink;
  const std::unique_ptr<Executor> executor = MakeThreadPool(1);
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session,
                          Session::Create(options.bench.config, rig, &sink, executor.get(), vocabulary));
  Drive drive(options, frames, session.get());
  std::vector<TrialResult> results;
  const auto trials = static_cast<size_t>(options.trials);
  const size_t first = drive.FirstTrial();
  size_t next = 0;
  int lost = 0;
  for (size_t trial = 1; trial <= trials; ++trial) {
    const size_t at = first + (trial - 1) * (frames.size() - first) / (trials + 2);
    for (; next < at; ++next) {
      SEMMAP_ASSIGN_OR_RETURN(const bool tracked, drive.Show(next));
      lost = tracked ? 0 : lost + 1;
      if (lost > options.patience)
        return absl::FailedPreconditionError(absl::StrCat("lost at frame ", next, ", outside of any trial"));
    }
    SEMMAP_ASSIGN_OR_RETURN(const TrialResult result, drive.Try(ordeal, at));
    results.push_back(result);
    if (!result.found_after) break;  // the rest of the drive would say nothing
    next = drive.last_index() + 1;
  }
  return results;
}

}  // namespace

const char* NameOf(Ordeal ordeal) {
  switch (ordeal) {
    case Ordeal::kBlindfold:
      return "blindfold";
    case Ordeal::kBack:
      return "back";
    case Ordeal::kKidnap:
      return "kidnap";
  }
  return "";
}

absl::StatusOr<std::vector<TrialResult>> RunTrials(const RelocalizationOptions& options) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<client::FrameSource> source,
                          client::OpenSource(options.bench.source, options.bench.source_options));
  SEMMAP_ASSIGN_OR_RETURN(const auto vocabulary, LoadVocabulary(options.bench.config.place));
  SEMMAP_ASSIGN_OR_RETURN(const auto frames, ReadAll(*source, options.bench.max_frames));
  std::vector<TrialResult> all;
  for (const Ordeal ordeal : {Ordeal::kBlindfold, Ordeal::kBack, Ordeal::kKidnap}) {
    SEMMAP_ASSIGN_OR_RETURN(const auto results,
                            RunOrdeal(options, ordeal, frames, source->rig(), vocabulary));
    all.insert(all.end(), results.begin(), results.end());
  }
  return all;
}

}  // namespace semmap::bench
