#include "client/cli/drive_session.h"

#include <map>
#include <memory>
#include <optional>

#include "client/cli/drive_report.h"
#include "client/cli/interrupt.h"
#include "client/cli/rig_conversion.h"
#include "client/cli/session_trajectory.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/association.h"
#include "slam/evaluation/ate.h"

namespace semmap::client {
namespace {

void AddSessionOptions(CLI::App& command, DriveSessionOptions* options) {
  static const std::map<std::string, v1::SessionMode> modes = {{"map", v1::SESSION_MODE_MAP},
                                                               {"extend", v1::SESSION_MODE_EXTEND},
                                                               {"localize", v1::SESSION_MODE_LOCALIZE}};
  static const std::map<std::string, v1::OverloadPolicy> policies = {
      {"block", v1::OVERLOAD_POLICY_BLOCK}, {"latest-wins", v1::OVERLOAD_POLICY_LATEST_WINS}};
  command.add_option("--mode", options->mode, "map|extend|localize; default map")
      ->transform(CLI::CheckedTransformer(modes));
  command.add_option("--map", options->map, "Name of the map");
  command.add_option("--vehicle", options->vehicle, "Id of the vehicle");
  command
      .add_option("--policy", options->policy,
                  "When the server is too slow: block|latest-wins; default block")
      ->transform(CLI::CheckedTransformer(policies));
  command.add_flag("--no-resume", options->no_resume, "Give up when the stream breaks");
  CLI::Option* realtime =
      command.add_flag("--realtime", options->realtime, "Send at the pace at which the frames were taken");
  command.add_flag("--pipelined", options->pipelined, "Send ahead of the answers, as credit allows")
      ->excludes(realtime);
}

void AddOutputOptions(CLI::App& command, DriveSessionOptions* options) {
  static const std::map<std::string, TrajectoryFormat> formats = {{"tum", TrajectoryFormat::kTum},
                                                                  {"kitti", TrajectoryFormat::kKitti}};
  command.add_option("--trajectory", options->trajectory,
                     "Write the trajectory that the server holds in the end");
  command.add_option("--format", options->format, "Of the trajectory: tum|kitti; default tum")
      ->transform(CLI::CheckedTransformer(formats));
  command.add_flag("--online", options->online, "Write the poses as they were answered instead");
  command.add_flag("--json", options->json, "Print a JSON summary");
}

DriveOptions DriveOptionsOf(const DriveSessionOptions& options, const CameraRig& rig) {
  DriveOptions drive;
  drive.vehicle_id = options.vehicle;
  drive.mode = options.mode;
  drive.map = options.map;
  drive.rig = ToProto(rig);
  drive.overload_policy = options.policy;
  drive.user_agent = "semmap-cli";
  drive.resume = !options.no_resume;
  return drive;
}

PlayOptions PlayOptionsOf(const DriveSessionOptions& options) {
  PlayOptions play;
  if (options.realtime) play.pace = Pace::kRealtime;
  if (options.pipelined) play.pace = Pace::kPipelined;
  play.max_frames = options.max_frames;
  return play;
}

absl::Status WriteDriveTrajectory(const DriveSessionOptions& options, const SequencedPoses& poses,
                                  uint64_t last_sequence, const Console& console) {
  if (options.format == TrajectoryFormat::kTum) {
    return WriteTrajectory(options.trajectory, WithHoles(poses), TrajectoryFormat::kTum);
  }
  uint64_t filled = 0;
  const Trajectory trajectory = WithoutHoles(poses, 1, last_sequence, &filled);
  if (filled > 0) {
    console.err << "semmap: " << filled << " of " << last_sequence
                << " frames have no pose; the KITTI file repeats the last known one for them\n";
  }
  return WriteTrajectory(options.trajectory, trajectory, TrajectoryFormat::kKitti);
}

// Nothing where the truth is not known, or too few poses are to be aligned with it.
std::optional<AteResult> CompareWithTruth(const FrameSource& source, const SequencedPoses& poses) {
  if (!source.ground_truth()) return std::nullopt;
  const auto pairs = AssociateByTime(*source.ground_truth(), WithHoles(poses));
  if (!pairs.ok()) return std::nullopt;
  auto ate = ComputeAte(*pairs, DriveAlignment(source.rig().sensor));
  if (!ate.ok()) return std::nullopt;
  return *std::move(ate);
}

}  // namespace

void AddDriveSessionOptions(CLI::App& command, DriveSessionOptions* options) {
  AddServerOptions(command, &options->server);
  AddSessionOptions(command, options);
  AddOutputOptions(command, options);
}

absl::Status DriveSession(FrameSource& source, const DriveSessionOptions& options, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(options.server));
  DriveMonitor monitor;
  SEMMAP_ASSIGN_OR_RETURN(
      const std::unique_ptr<Drive> drive,
      Drive::Start(connection, DriveOptionsOf(options, source.rig()), monitor.Observer()));
  CatchInterrupts();
  SEMMAP_ASSIGN_OR_RETURN(const PlayResult result,
                          Play(source, *drive, monitor, PlayOptionsOf(options), console));
  SequencedPoses stored;
  if (source.ground_truth() || (!options.trajectory.empty() && !options.online)) {
    const v1::Session& session = result.summary.session();
    Client client(connection);
    SEMMAP_ASSIGN_OR_RETURN(auto sessions, FetchTrajectories(client, session.map(), session.name()));
    stored = std::move(sessions[session.name()]);
  }
  if (!options.trajectory.empty()) {
    SEMMAP_RETURN_IF_ERROR(WriteDriveTrajectory(options, options.online ? monitor.online_poses() : stored,
                                                result.last_sequence, console));
  }
  nlohmann::json summary = DriveJson(result, monitor.latencies(), options.trajectory);
  if (const std::optional<AteResult> ate = CompareWithTruth(source, stored)) {
    AddTruth(*ate, source.rig().sensor, &summary);
  }
  console.out << (options.json ? summary.dump(2) + "\n" : DriveTable(summary));
  return result.interrupted
             ? absl::CancelledError("interrupted; the session was ended and what was sent is stored")
             : absl::OkStatus();
}

}  // namespace semmap::client
