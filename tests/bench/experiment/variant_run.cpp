#include "tests/bench/experiment/variant_run.h"

#include <algorithm>
#include <deque>
#include <memory>

#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/ate.h"
#include "slam/evaluation/mape.h"
#include "slam/evaluation/statistics.h"
#include "slam/pipeline/session.h"
#include "slam/place/vocabulary.h"

namespace semmap::bench {
namespace {

// Labels of the newest frames, by sequence number.
class LabelHistory {
 public:
  void Add(uint64_t sequence, cv::Mat labels) {
    frames_.emplace_back(sequence, std::move(labels));
    if (frames_.size() > CensusSink::kHistory + 1) frames_.pop_front();
  }
  // A session takes nothing else into its map than what it was just given.
  cv::Mat Find(uint64_t sequence) const {
    const auto found = std::find_if(frames_.begin(), frames_.end(),
                                    [&](const auto& frame) { return frame.first == sequence; });
    return found == frames_.end() ? frames_.front().second : found->second;
  }

 private:
  std::deque<std::pair<uint64_t, cv::Mat>> frames_;
};

// What all variants get of one frame.
struct Frame {
  FrameInput input;
  cv::Mat true_classes;
  RecordedDrive::Masks model;
};

// One variant on its way along the drive.
class VariantRun {
 public:
  static absl::StatusOr<std::unique_ptr<VariantRun>> Start(const Variant& variant, const RunOptions& options,
                                                           const CameraRig& rig, const LabelHistory& labels,
                                                           std::shared_ptr<const Vocabulary> vocabulary) {
    std::unique_ptr<VariantRun> run(new VariantRun(variant, variant.Configure(options.config), labels));
    SEMMAP_ASSIGN_OR_RETURN(run->session_,
                            Session::Create(run->config_, rig, &run->sink_, nullptr, std::move(vocabulary)));
    return run;
  }

  absl::Status Track(const Frame& frame) {
    FrameInput input = frame.input;
    if (variant_.masks == MaskSource::kTruth) input.class_mask = frame.true_classes;
    if (variant_.masks == MaskSource::kModel) {
      input.class_mask = frame.model.classes;
      input.class_confidence = frame.model.confidence;
    }
    SEMMAP_ASSIGN_OR_RETURN(const FrameResult result, session_->Track(input));
    track_ms_.push_back(result.times.total_ms);
    return absl::OkStatus();
  }

  VariantResult Finish(const RecordedDrive& drive, int run, int frames) {
    session_->Finish();
    VariantResult result;
    result.route = drive.key().route;
    result.traffic_seed = drive.key().traffic_seed;
    result.run = run;
    result.variant = variant_.name;
    result.frames = frames;
    result.duration_s =
        ToSeconds(drive.truth().poses.back().timestamp - drive.truth().poses.front().timestamp);
    result.length_m = PathLength(drive.truth());
    const SessionStats stats = session_->Stats();
    result.keyframes = stats.keyframes;
    result.points = stats.points;
    result.loops = stats.loops;
    result.recoveries = stats.recoveries;
    result.track_ms = Percentile(track_ms_, 0.5);
    result.census = sink_.TakeCensus();
    Compare(drive.truth(), &result);
    return result;
  }

 private:
  VariantRun(const Variant& variant, const SlamConfig& config, const LabelHistory& labels)
      : variant_(variant),
        config_(config),
        sink_([&labels](uint64_t sequence) { return labels.Find(sequence); },
              config.semantics.InactiveClasses()) {}

  void Compare(const Trajectory& truth, VariantResult* result) const {
    const Trajectory estimate = sink_.trajectory().Compose();
    result->tracked = static_cast<int>(estimate.size());
    const auto pairs = AssociateByTime(truth, estimate);
    if (!pairs.ok()) return;
    MapeOptions options;
    options.axes = {{0, 1}};  // east and north
    const auto mape = ComputeMape(*pairs, options);
    const auto ate = ComputeAte(*pairs, Alignment::kSim3);
    if (!mape.ok() || !ate.ok()) return;
    result->mape_percent = mape->mape_percent;
    result->ate_m = ate->translation_m.rmse;
    result->error_m = mape->errors_m;
    for (const PosePair& pair : *pairs) {
      result->frame.push_back(static_cast<int>(pair.reference_index));
      const Eigen::Vector3d position = mape->reference_from_estimate * pair.estimate.translation();
      result->estimate.emplace_back(position.x(), position.y());
    }
  }

  Variant variant_;
  SlamConfig config_;
  CensusSink sink_;
  std::unique_ptr<Session> session_;
  std::vector<double> track_ms_;
};

// Two frames further in each run.
int FirstFrame(int run) { return 2 * (run - 1); }

absl::StatusOr<Frame> ReadFrame(const RecordedDrive& drive, int index, const std::string& model,
                                LabelHistory* labels) {
  Frame frame;
  frame.input.sequence = static_cast<uint64_t>(index);
  frame.input.timestamp = drive.truth().poses[static_cast<size_t>(index)].timestamp;
  SEMMAP_ASSIGN_OR_RETURN(const cv::Mat image, drive.ReadImage(index));
  cv::cvtColor(image, frame.input.image, cv::COLOR_BGR2GRAY);
  SEMMAP_ASSIGN_OR_RETURN(cv::Mat codes, drive.ReadLabels(index));
  frame.true_classes = codes & kTruthClassBits;
  labels->Add(frame.input.sequence, std::move(codes));
  if (!model.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(frame.model, drive.ReadMasks(model, index));
  }
  return frame;
}

}  // namespace

absl::StatusOr<std::vector<VariantResult>> RunVariants(const RecordedDrive& drive,
                                                       const std::vector<Variant>& variants,
                                                       const RunOptions& options,
                                                       const std::function<void(int)>& progress) {
  LabelHistory labels;
  SEMMAP_ASSIGN_OR_RETURN(const auto vocabulary, LoadVocabulary(options.config.place));
  std::vector<std::unique_ptr<VariantRun>> runs;
  bool use_model = false;
  for (const Variant& variant : variants) {
    SEMMAP_ASSIGN_OR_RETURN(runs.emplace_back(),
                            VariantRun::Start(variant, options, drive.rig(), labels, vocabulary));
    use_model |= variant.masks == MaskSource::kModel;
  }
  int played = 0;
  for (int index = FirstFrame(options.run); index < drive.frames(); index += options.frame_step, ++played) {
    SEMMAP_ASSIGN_OR_RETURN(const Frame frame,
                            ReadFrame(drive, index, use_model ? options.model : "", &labels));
    for (const auto& run : runs) SEMMAP_RETURN_IF_ERROR(run->Track(frame));
    progress(index + 1);
  }
  std::vector<VariantResult> results;
  for (const auto& run : runs) results.push_back(run->Finish(drive, options.run, played));
  return results;
}

}  // namespace semmap::bench
