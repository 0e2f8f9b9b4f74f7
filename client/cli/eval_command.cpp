// semmap eval ate|rpe|mape: compares a trajectory with the truth, offline.

#include <memory>

#include "absl/strings/str_format.h"
#include "client/cli/commands.h"
#include "client/cli/eval_input.h"
#include "client/cli/eval_report.h"
#include "client/cli/trajectory_plot.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct RpeOptions {
  SegmentRpeOptions segments;
  IntervalRpeOptions interval;
};

absl::Status PlotIfAsked(const EvalOptions& options, const EvalInput& input,
                         const Sim3& reference_from_estimate, const std::vector<double>& errors_m,
                         const std::string& title) {
  if (options.plot.empty()) return absl::OkStatus();
  return WriteTrajectoryPlot(options.plot, {input.reference, input.estimate, input.pairs,
                                            reference_from_estimate, errors_m, input.by_time, title});
}

void Print(const Console& console, bool json, const nlohmann::json& figures, const std::string& table) {
  console.out << (json ? figures.dump(2) + "\n" : table);
}

absl::Status RunAte(const EvalOptions& options, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const EvalInput input, ReadEvalInput(options));
  SEMMAP_ASSIGN_OR_RETURN(const AteResult ate, ComputeAte(input.pairs, options.alignment));
  const std::string title = absl::StrFormat("Absolute trajectory error: RMSE %.4g m, aligned: %s",
                                            ate.translation_m.rmse, AlignmentName(options.alignment));
  SEMMAP_RETURN_IF_ERROR(PlotIfAsked(options, input, ate.reference_from_estimate, ate.errors_m, title));
  Print(console, options.json, AteJson(options, input, ate), AteTable(options, input, ate));
  return absl::OkStatus();
}

absl::Status RunRpe(const EvalOptions& options, RpeOptions rpe, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const EvalInput input, ReadEvalInput(options));
  // Only the scale of the alignment matters: relative poses do not depend on the map frame.
  SEMMAP_ASSIGN_OR_RETURN(const AteResult ate, ComputeAte(input.pairs, options.alignment));
  rpe.segments.estimate_scale = ate.reference_from_estimate.scale;
  rpe.interval.estimate_scale = ate.reference_from_estimate.scale;
  if (!input.by_time && rpe.interval.delta_frames == 0) rpe.interval.delta_frames = 1;
  RpeResult result;
  result.scale = ate.reference_from_estimate.scale;
  result.interval_options = rpe.interval;
  SEMMAP_ASSIGN_OR_RETURN(result.interval, ComputeIntervalRpe(input.pairs, rpe.interval));
  const absl::StatusOr<SegmentRpeResult> segments = ComputeSegmentRpe(input.pairs, rpe.segments);
  if (segments.ok()) {
    result.segments = *segments;
  } else if (!absl::IsFailedPrecondition(segments.status())) {
    return segments.status();
  }
  const std::string title =
      absl::StrFormat("Position error over time, aligned: %s", AlignmentName(options.alignment));
  SEMMAP_RETURN_IF_ERROR(PlotIfAsked(options, input, ate.reference_from_estimate, ate.errors_m, title));
  Print(console, options.json, RpeJson(options, input, result), RpeTable(input, result));
  return absl::OkStatus();
}

absl::Status RunMape(const EvalOptions& options, MapeOptions mape_options, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const EvalInput input, ReadEvalInput(options));
  mape_options.alignment = options.alignment;
  SEMMAP_ASSIGN_OR_RETURN(const MapeResult mape, ComputeMape(input.pairs, mape_options));
  const std::string title = absl::StrFormat("Ground-plane position error, MAPE %.4g %%, aligned: %s",
                                            mape.mape_percent, AlignmentName(options.alignment));
  SEMMAP_RETURN_IF_ERROR(PlotIfAsked(options, input, mape.reference_from_estimate, mape.errors_m, title));
  Print(console, options.json, MapeJson(options, input, mape), MapeTable(input, mape));
  return absl::OkStatus();
}

void AddAte(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("ate", "Absolute trajectory error");
  auto options = std::make_shared<EvalOptions>();
  AddEvalOptions(*command, options.get());
  command->callback([options, action] {
    *action = [options](const Console& console) { return RunAte(*options, console); };
  });
}

void AddRpe(CLI::App& parent, Action* action) {
  CLI::App* command =
      parent.add_subcommand("rpe", "Relative pose error: KITTI's segments, and over a fixed interval");
  auto options = std::make_shared<EvalOptions>();
  options->alignment = Alignment::kNone;
  auto rpe = std::make_shared<RpeOptions>();
  AddEvalOptions(*command, options.get());
  command->add_option("--lengths", rpe->segments.lengths_m,
                      "Segment lengths, metres; default 100 to 800, shorter for "
                      "short paths");
  command->add_option("--step", rpe->segments.step, "Poses between the starts of segments")
      ->check(CLI::PositiveNumber);
  CLI::Option* seconds = command->add_option("--delta", rpe->interval.delta_s, "Interval, seconds; default 1")
                             ->check(CLI::PositiveNumber);
  command->add_option("--delta-frames", rpe->interval.delta_frames, "Interval, poses")
      ->check(CLI::PositiveNumber)
      ->excludes(seconds);
  command->callback([options, rpe, action] {
    *action = [options, rpe](const Console& console) { return RunRpe(*options, *rpe, console); };
  });
}

void AddMape(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("mape", "Mean absolute percentage error of the ground position");
  auto options = std::make_shared<EvalOptions>();
  options->alignment = Alignment::kSim3;
  auto mape = std::make_shared<MapeOptions>();
  auto axes = std::make_shared<std::string>();
  AddEvalOptions(*command, options.get());
  command->add_option("--axes", *axes, "Ground plane: xy, xz or yz; default: the two longest")
      ->check(CLI::IsMember({"xy", "xz", "yz"}));
  command
      ->add_option("--min-denominator", mape->min_denominator_m,
                   "Leave out true coordinates nearer to zero, metres; default 1")
      ->check(CLI::PositiveNumber);
  command->callback([options, mape, axes, action] {
    if (!axes->empty()) mape->axes = {{(*axes)[0] - 'x', (*axes)[1] - 'x'}};
    *action = [options, mape](const Console& console) { return RunMape(*options, *mape, console); };
  });
}

}  // namespace

void AddEvalCommand(CLI::App& parent, Action* action) {
  CLI::App* command =
      parent.add_subcommand("eval", "Compare a trajectory, or the classes of images, with the truth");
  command->require_subcommand(1);
  AddAte(*command, action);
  AddRpe(*command, action);
  AddMape(*command, action);
  AddEvalSegmentationCommand(*command, action);
}

}  // namespace semmap::client
