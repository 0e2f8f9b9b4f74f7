#include "client/cli/eval_input.h"

#include <map>

#include "client/cli/console.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

const std::map<std::string, TrajectoryFormat>& Formats() {
  static const std::map<std::string, TrajectoryFormat> formats = {{"tum", TrajectoryFormat::kTum},
                                                                  {"kitti", TrajectoryFormat::kKitti}};
  return formats;
}

const std::map<std::string, Alignment>& Alignments() {
  static const std::map<std::string, Alignment> alignments = {
      {"none", Alignment::kNone}, {"se3", Alignment::kSe3}, {"sim3", Alignment::kSim3}};
  return alignments;
}

absl::StatusOr<Trajectory> ReadWithTimes(const std::string& path, TrajectoryFormat format,
                                         const std::string& times_path) {
  SEMMAP_ASSIGN_OR_RETURN(Trajectory trajectory, ReadTrajectory(path, format));
  if (format == TrajectoryFormat::kTum || times_path.empty()) return trajectory;
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<TimestampNs> times, ReadTimes(times_path));
  SEMMAP_RETURN_IF_ERROR(AttachTimes(times, &trajectory));
  return trajectory;
}

absl::Status CheckTimes(const EvalOptions& options) {
  const auto timed = [](TrajectoryFormat format, const std::string& times) {
    return format == TrajectoryFormat::kTum || !times.empty();
  };
  const bool reference_timed = timed(options.reference_format, options.reference_times);
  const bool estimate_timed = timed(options.estimate_format, options.estimate_times);
  if (options.estimate_format == TrajectoryFormat::kTum && !reference_timed) {
    return UsageError(
        "a KITTI reference has no times to find the poses of a TUM estimate by: add --reference-times FILE");
  }
  if (options.reference_format == TrajectoryFormat::kTum && !estimate_timed) {
    return UsageError(
        "a KITTI estimate has no times to find its poses in a TUM reference by: add --estimate-times FILE");
  }
  return absl::OkStatus();
}

}  // namespace

const char* AlignmentName(Alignment alignment) {
  switch (alignment) {
    case Alignment::kNone:
      return "none";
    case Alignment::kSe3:
      return "se3";
    case Alignment::kSim3:
      return "sim3";
  }
  return "";
}

void AddEvalOptions(CLI::App& command, EvalOptions* options) {
  command.add_option("--reference", options->reference, "True trajectory")->required();
  command.add_option("--reference-format", options->reference_format, "tum|kitti; default tum")
      ->transform(CLI::CheckedTransformer(Formats()));
  command.add_option("--reference-times", options->reference_times,
                     "times.txt of a KITTI reference; not needed for others");
  command.add_option("--estimate", options->estimate, "Trajectory to judge")->required();
  command.add_option("--format", options->estimate_format, "Of the estimate: tum|kitti; default tum")
      ->transform(CLI::CheckedTransformer(Formats()));
  command.add_option("--estimate-times", options->estimate_times,
                     "times.txt of a KITTI estimate; not needed for others");
  command.add_option("--align", options->alignment, "se3|sim3|none")
      ->transform(CLI::CheckedTransformer(Alignments()));
  command
      .add_option("--max-time-difference", options->max_time_difference_s,
                  "Seconds between poses that belong together; default 0.02")
      ->check(CLI::Range(0.0, 3600.0));
  command.add_option("--plot", options->plot, "Draw trajectories and error over time (PNG)");
  command.add_flag("--json", options->json, "Print JSON");
}

absl::StatusOr<EvalInput> ReadEvalInput(const EvalOptions& options) {
  SEMMAP_RETURN_IF_ERROR(CheckTimes(options));
  EvalInput input;
  SEMMAP_ASSIGN_OR_RETURN(
      input.reference, ReadWithTimes(options.reference, options.reference_format, options.reference_times));
  SEMMAP_ASSIGN_OR_RETURN(input.estimate,
                          ReadWithTimes(options.estimate, options.estimate_format, options.estimate_times));
  input.by_time = input.reference.timed && input.estimate.timed;
  if (input.by_time) {
    SEMMAP_ASSIGN_OR_RETURN(input.pairs,
                            AssociateByTime(input.reference, input.estimate, options.max_time_difference_s));
  } else {
    SEMMAP_ASSIGN_OR_RETURN(input.pairs, AssociateByIndex(input.reference, input.estimate));
  }
  return input;
}

}  // namespace semmap::client
