#include "tests/bench/slam_bench_run.h"

#include <chrono>
#include <memory>
#include <thread>

#include "slam/common/status_macros.h"
#include "slam/evaluation/ate.h"
#include "slam/pipeline/session.h"
#include "tests/bench/slam_bench_meters.h"

namespace semmap::bench {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Lets a frame begin when its recording did.
class Pacer {
 public:
  void WaitFor(TimestampNs timestamp) {
    if (!first_) first_ = {Clock::now(), timestamp};
    std::this_thread::sleep_until(first_->first + std::chrono::nanoseconds(timestamp - first_->second));
  }

 private:
  std::optional<std::pair<Clock::time_point, TimestampNs>> first_;
};

// One recording on its way through one session.
class Run {
 public:
  Run(const BenchOptions& options, client::FrameSource& source, Session& session)
      : options_(options), source_(source), session_(session), unit_(source.frame_count()) {}

  absl::Status PlayAll(RunResult* result) {
    while (options_.max_frames == 0 || result->frames < static_cast<uint64_t>(options_.max_frames)) {
      SEMMAP_ASSIGN_OR_RETURN(const std::optional<client::SourceFrame> frame, source_.Next());
      if (!frame) break;
      SEMMAP_RETURN_IF_ERROR(PlayOne(*frame, result));
    }
    session_.Finish();
    NoteMapping(result);
    result->stages.unit = unit_.milliseconds();
    result->stages.unit_cpu = unit_.cpu_milliseconds();
    return absl::OkStatus();
  }

  double unit_cpu_seconds() const { return unit_.cpu_seconds(); }

 private:
  absl::Status PlayOne(const client::SourceFrame& frame, RunResult* result) {
    const auto start = Clock::now();
    SEMMAP_ASSIGN_OR_RETURN(const FrameInput input, DecodeFrame(frame, options_.segmentation != nullptr));
    result->stages.decode.push_back(MillisecondsSince(start));
    unit_.Offer(input.image);
    if (options_.realtime) {
      pacer_.WaitFor(frame.timestamp);
    } else {
      session_.WaitForMapper(options_.backlog);
    }
    NoteMapping(result);
    SEMMAP_ASSIGN_OR_RETURN(const FrameResult tracked, session_.Track(input));
    NoteTracking(tracked, result);
    return absl::OkStatus();
  }

  static void NoteTracking(const FrameResult& tracked, RunResult* result) {
    ++result->frames;
    if (tracked.state == TrackingState::kTracking) ++result->tracked;
    result->stages.extract.push_back(tracked.times.extract_ms);
    result->stages.stereo.push_back(tracked.times.stereo_ms);
    result->stages.classify.push_back(tracked.times.classify_ms);
    result->stages.match.push_back(tracked.times.match_ms);
    result->stages.optimize.push_back(tracked.times.optimize_ms);
    result->stages.track.push_back(tracked.times.total_ms);
  }

  void NoteMapping(RunResult* result) {
    const double map_ms = session_.Stats().map_ms;
    if (map_ms > mapped_ms_) result->stages.map.push_back(map_ms - mapped_ms_);
    mapped_ms_ = map_ms;
  }

  const BenchOptions& options_;
  client::FrameSource& source_;
  Session& session_;
  UnitTimer unit_;
  Pacer pacer_;
  double mapped_ms_ = 0;
};

absl::StatusOr<std::optional<double>> CompareWithTruth(const client::FrameSource& source,
                                                       const Trajectory& trajectory) {
  if (!source.ground_truth() || trajectory.empty()) return std::nullopt;
  const bool mono = source.rig().sensor == SensorType::kMono;
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<PosePair> pairs,
                          AssociateByTime(*source.ground_truth(), trajectory));
  SEMMAP_ASSIGN_OR_RETURN(const AteResult ate, ComputeAte(pairs, mono ? Alignment::kSim3 : Alignment::kSe3));
  return ate.translation_m.rmse;
}

}  // namespace

absl::StatusOr<FrameInput> DecodeFrame(const client::SourceFrame& frame, bool with_colour) {
  FrameInput input;
  input.sequence = frame.sequence;
  input.timestamp = frame.timestamp;
  SEMMAP_ASSIGN_OR_RETURN(input.image, client::DecodeGray(frame.image));
  if (with_colour) {
    SEMMAP_ASSIGN_OR_RETURN(input.colour, client::DecodeColour(frame.image));
  }
  if (!frame.right.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(input.right, client::DecodeGray(frame.right));
  }
  if (!frame.depth.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(input.depth, client::DecodeDepth(frame.depth));
  }
  if (!frame.class_mask.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(input.class_mask, client::DecodeClasses(frame.class_mask));
  }
  return input;
}

absl::StatusOr<RunResult> RunOnce(const BenchOptions& options) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<client::FrameSource> source,
                          client::OpenSource(options.source, options.source_options));
  SEMMAP_ASSIGN_OR_RETURN(const auto vocabulary, LoadVocabulary(options.config.place));
  SlamConfig config = options.config;
  if (!options.close_loops) config.loop.enabled = false;
  if (!options.realtime) config.segmentation.max_wait_ms = 0;
  MeasuringSink sink;
  const std::unique_ptr<Executor> executor = MakeThreadPool(1);
  SEMMAP_ASSIGN_OR_RETURN(
      const std::unique_ptr<Session> session,
      Session::Create(config, source->rig(), &sink, executor.get(), vocabulary, options.segmentation));
  RunResult result;
  const double cpu_before = ProcessCpuSeconds();
  const auto start = Clock::now();
  Run run(options, *source, *session);
  SEMMAP_RETURN_IF_ERROR(run.PlayAll(&result));
  result.wall_s = 1e-3 * MillisecondsSince(start);
  result.cpu_s = ProcessCpuSeconds() - cpu_before - run.unit_cpu_seconds();
  result.peak_rss_mb = PeakRssMb();
  const SessionStats stats = session->Stats();
  result.keyframes = stats.keyframes;
  result.points = stats.points;
  result.loops = stats.loops;
  result.recoveries = stats.recoveries;
  result.classified = stats.classified_frames;
  result.unclassified = stats.unclassified_frames;
  result.bytes_per_keyframe = sink.BytesPerKeyFrame();
  result.bytes_per_point = sink.BytesPerPoint();
  result.trajectory = sink.collector().Compose();
  // Too few tracked poses to align is a poor result, not a failed run.
  result.ate_rmse_m = CompareWithTruth(*source, result.trajectory).value_or(std::nullopt);
  return result;
}

}  // namespace semmap::bench
