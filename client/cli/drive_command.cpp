// semmap drive: plays a recording to a server as a vehicle would.

#include <map>
#include <memory>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/drive_report.h"
#include "client/cli/drive_runner.h"
#include "client/cli/interrupt.h"
#include "client/cli/rig_conversion.h"
#include "client/cli/server_options.h"
#include "client/names.h"
#include "client/sources/open_source.h"
#include "slam/common/status_macros.h"
#include "slam/evaluation/trajectory_io.h"

namespace semmap::client {
namespace {

struct DriveArguments {
  ServerOptions server;
  std::string source;
  SourceOptions source_options;
  v1::SessionMode mode = v1::SESSION_MODE_MAP;
  v1::OverloadPolicy policy = v1::OVERLOAD_POLICY_BLOCK;
  std::string map;
  std::string vehicle;
  std::string trajectory;
  TrajectoryFormat format = TrajectoryFormat::kTum;
  PlayOptions play;
  bool realtime = false;
  bool pipelined = false;
  bool online = false;
  bool no_resume = false;
  bool json = false;
};

void AddRecordingOptions(CLI::App& command, DriveArguments* arguments) {
  static const std::map<std::string, SensorType> sensors = {
      {"mono", SensorType::kMono}, {"stereo", SensorType::kStereo}, {"rgbd", SensorType::kRgbd}};
  command.add_option("--source", arguments->source, SourceSpecHelp())
      ->required()
      ->check([](const std::string& spec) {
        return IsSourceSpec(spec) ? std::string() : absl::StrCat("is not one of ", SourceSpecHelp());
      });
  command.add_option("--sensor", arguments->source_options.sensor, "mono|stereo|rgbd")
      ->required()
      ->transform(CLI::CheckedTransformer(sensors));
  command.add_option("--camera", arguments->source_options.camera_file, "Camera file (YAML)");
  command.add_option("--frames", arguments->play.max_frames, "Stop after so many frames");
  CLI::Option* realtime = command.add_flag("--realtime", arguments->realtime, "Send at the recorded times");
  command.add_flag("--pipelined", arguments->pipelined, "Send ahead of the answers, as credit allows")
      ->excludes(realtime);
}

void AddSessionOptions(CLI::App& command, DriveArguments* arguments) {
  static const std::map<std::string, v1::SessionMode> modes = {{"map", v1::SESSION_MODE_MAP},
                                                               {"extend", v1::SESSION_MODE_EXTEND},
                                                               {"localize", v1::SESSION_MODE_LOCALIZE}};
  static const std::map<std::string, v1::OverloadPolicy> policies = {
      {"block", v1::OVERLOAD_POLICY_BLOCK}, {"latest-wins", v1::OVERLOAD_POLICY_LATEST_WINS}};
  command.add_option("--mode", arguments->mode, "map|extend|localize; default map")
      ->transform(CLI::CheckedTransformer(modes));
  command.add_option("--map", arguments->map, "Name of the map")->required();
  command.add_option("--vehicle", arguments->vehicle, "Id of the vehicle")->required();
  command
      .add_option("--policy", arguments->policy,
                  "When the server is too slow: block|latest-wins; default block")
      ->transform(CLI::CheckedTransformer(policies));
  command.add_flag("--no-resume", arguments->no_resume, "Give up when the stream breaks");
}

void AddOutputOptions(CLI::App& command, DriveArguments* arguments) {
  static const std::map<std::string, TrajectoryFormat> formats = {{"tum", TrajectoryFormat::kTum},
                                                                  {"kitti", TrajectoryFormat::kKitti}};
  command.add_option("--trajectory", arguments->trajectory,
                     "Write the trajectory that the server holds in the end");
  command.add_option("--format", arguments->format, "Of the trajectory: tum|kitti; default tum")
      ->transform(CLI::CheckedTransformer(formats));
  command.add_flag("--online", arguments->online, "Write the poses as they were answered instead");
  command.add_flag("--json", arguments->json, "Print a JSON summary");
}

absl::Status WriteDriveTrajectory(const DriveArguments& arguments, const SequencedPoses& poses,
                                  uint64_t last_sequence, const Console& console) {
  if (arguments.format == TrajectoryFormat::kTum) {
    return WriteTrajectory(arguments.trajectory, WithHoles(poses), TrajectoryFormat::kTum);
  }
  uint64_t filled = 0;
  const Trajectory trajectory = WithoutHoles(poses, 1, last_sequence, &filled);
  if (filled > 0) {
    console.err << "semmap: " << filled << " of " << last_sequence
                << " frames have no pose; the KITTI file repeats the last known one for them\n";
  }
  return WriteTrajectory(arguments.trajectory, trajectory, TrajectoryFormat::kKitti);
}

absl::Status SaveTrajectory(const DriveArguments& arguments, const std::shared_ptr<Connection>& connection,
                            const PlayResult& result, const DriveMonitor& monitor, const Console& console) {
  if (arguments.trajectory.empty()) return absl::OkStatus();
  SequencedPoses poses;
  if (arguments.online) {
    poses = monitor.online_poses();
  } else {
    const v1::Session& session = result.summary.session();
    Client client(connection);
    SEMMAP_ASSIGN_OR_RETURN(auto sessions, FetchTrajectories(client, session.map(), session.name()));
    poses = std::move(sessions[session.name()]);
  }
  return WriteDriveTrajectory(arguments, poses, result.last_sequence, console);
}

DriveOptions DriveOptionsOf(const DriveArguments& arguments, const CameraRig& rig) {
  DriveOptions options;
  options.vehicle_id = arguments.vehicle;
  options.mode = arguments.mode;
  options.map = arguments.map;
  options.rig = ToProto(rig);
  options.overload_policy = arguments.policy;
  options.user_agent = "semmap-cli";
  options.resume = !arguments.no_resume;
  return options;
}

absl::Status RunDrive(const DriveArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<FrameSource> source,
                          OpenSource(arguments.source, arguments.source_options));
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  DriveMonitor monitor;
  SEMMAP_ASSIGN_OR_RETURN(
      const std::unique_ptr<Drive> drive,
      Drive::Start(connection, DriveOptionsOf(arguments, source->rig()), monitor.Observer()));
  CatchInterrupts();
  SEMMAP_ASSIGN_OR_RETURN(const PlayResult result, Play(*source, *drive, monitor, arguments.play, console));
  SEMMAP_RETURN_IF_ERROR(SaveTrajectory(arguments, connection, result, monitor, console));
  const nlohmann::json summary = DriveJson(result, monitor.latencies(), arguments.trajectory);
  console.out << (arguments.json ? summary.dump(2) + "\n" : DriveTable(summary));
  return result.interrupted
             ? absl::CancelledError("interrupted; the session was ended and what was sent is stored")
             : absl::OkStatus();
}

}  // namespace

void AddDriveCommand(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("drive", "Play a recording to the server as a vehicle would");
  auto arguments = std::make_shared<DriveArguments>();
  AddServerOptions(*command, &arguments->server);
  AddRecordingOptions(*command, arguments.get());
  AddSessionOptions(*command, arguments.get());
  AddOutputOptions(*command, arguments.get());
  command->callback([arguments, action] {
    if (arguments->realtime) arguments->play.pace = Pace::kRealtime;
    if (arguments->pipelined) arguments->play.pace = Pace::kPipelined;
    *action = [arguments](const Console& console) { return RunDrive(*arguments, console); };
  });
}

}  // namespace semmap::client
