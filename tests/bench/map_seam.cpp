// Where two vehicles that mapped at once were, by the one map and in truth: how well the map fits together
// where what one mapped meets what the other did.
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/ate.h"
#include "slam/evaluation/trajectory_io.h"
#include "tests/bench/bench_main.h"

namespace semmap::bench {
namespace {

struct SeamOptions {
  std::string first;
  std::string first_truth;
  std::string first_times;
  std::string second;
  std::string second_truth;
  std::string second_times;
  double near_m = 3;
  bool with_scale = false;
};

struct Drive {
  std::vector<PosePair> pairs;
  size_t frames = 0;
};

absl::StatusOr<Drive> ReadDrive(const std::string& estimate, const std::string& truth,
                                const std::string& times) {
  SEMMAP_ASSIGN_OR_RETURN(const Trajectory estimated, ReadTumTrajectory(estimate));
  SEMMAP_ASSIGN_OR_RETURN(Trajectory true_poses, ReadKittiTrajectory(truth));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<TimestampNs> stamps, ReadTimes(times));
  SEMMAP_RETURN_IF_ERROR(AttachTimes(stamps, &true_poses));
  Drive drive;
  SEMMAP_ASSIGN_OR_RETURN(drive.pairs, AssociateByTime(true_poses, estimated));
  drive.frames = true_poses.size();
  return drive;
}

void PrintAte(const char* name, const Drive& drive, const Sim3& truth_from_map) {
  std::vector<double> errors;
  for (const PosePair& pair : drive.pairs)
    errors.push_back((truth_from_map * pair.estimate.translation() - pair.reference.translation()).norm());
  const ErrorStatistics error = Summarize(errors);
  absl::PrintF("%-24s %5d of %5d frames in the map, ATE %.3f m, greatest %.3f m\n", name, drive.pairs.size(),
               drive.frames, error.rmse, error.max);
}

// For each frame of the second drive that was taken near one of the first: how wrong the map's step between
// the two is.
std::vector<double> SeamErrors(const Drive& first, const Drive& second, double near_m, double scale) {
  std::vector<double> errors;
  for (const PosePair& there : second.pairs) {
    const PosePair* nearest = nullptr;
    double least = near_m;
    for (const PosePair& here : first.pairs) {
      const double distance = (here.reference.translation() - there.reference.translation()).norm();
      if (distance >= least) continue;
      least = distance;
      nearest = &here;
    }
    if (nearest == nullptr) continue;
    const SE3 true_step = nearest->reference.Inverse() * there.reference;
    const SE3 mapped_step = nearest->estimate.Inverse() * there.estimate;
    errors.push_back((scale * mapped_step.translation() - true_step.translation()).norm());
  }
  return errors;
}

absl::Status Run(const SeamOptions& options) {
  SEMMAP_ASSIGN_OR_RETURN(const Drive first,
                          ReadDrive(options.first, options.first_truth, options.first_times));
  SEMMAP_ASSIGN_OR_RETURN(const Drive second,
                          ReadDrive(options.second, options.second_truth, options.second_times));
  std::vector<PosePair> all = first.pairs;
  all.insert(all.end(), second.pairs.begin(), second.pairs.end());
  const Alignment alignment = options.with_scale ? Alignment::kSim3 : Alignment::kSe3;
  SEMMAP_ASSIGN_OR_RETURN(const Sim3 truth_from_map, AlignTrajectory(all, alignment));
  PrintAte("first, aligned together", first, truth_from_map);
  PrintAte("second", second, truth_from_map);
  SEMMAP_ASSIGN_OR_RETURN(const Sim3 truth_from_first, AlignTrajectory(first.pairs, alignment));
  PrintAte("second, by the first", second, truth_from_first);
  const std::vector<double> errors = SeamErrors(first, second, options.near_m, truth_from_map.scale);
  if (errors.empty()) return absl::FailedPreconditionError("the drives have no place in common");
  const ErrorStatistics seam = Summarize(errors);
  absl::PrintF(
      "seam: %d pairs of frames at most %.1f m apart, error %.3f m RMS, median %.3f m, 95 %% %.3f m, "
      "greatest %.3f m\n",
      seam.count, options.near_m, seam.rmse, seam.median, Percentile(errors, 0.95), seam.max);
  return absl::OkStatus();
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) {
  semmap::bench::SeamOptions options;
  CLI::App app("Seam of a map that two vehicles made, in metres, against the truth");
  app.add_option("--first", options.first, "Trajectory of one vehicle in the map (TUM)")->required();
  app.add_option("--first-truth", options.first_truth, "Its true poses (KITTI), in a frame that both share")
      ->required();
  app.add_option("--first-times", options.first_times, "Their times.txt")->required();
  app.add_option("--second", options.second, "The same of the other vehicle")->required();
  app.add_option("--second-truth", options.second_truth)->required();
  app.add_option("--second-times", options.second_times)->required();
  app.add_flag("--with-scale", options.with_scale, "The map's unit is not known (one camera): fit it too");
  app.add_option("--near", options.near_m,
                 "Frames of both that are at most so far apart are compared, metres");
  return semmap::bench::RunMain(app, "map_seam", argc, argv,
                                [&options] { return semmap::bench::Run(options); });
}
