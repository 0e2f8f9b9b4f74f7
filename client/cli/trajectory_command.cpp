// semmap trajectory: where the vehicles of a map drove, as the map has it now.

#include <map>
#include <memory>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/server_options.h"
#include "client/cli/session_trajectory.h"
#include "client/names.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"
#include "slam/evaluation/trajectory_io.h"

namespace semmap::client {
namespace {

struct TrajectoryArguments {
  ServerOptions server;
  std::string map;
  std::string session;
  std::string output;
  TrajectoryFormat format = TrajectoryFormat::kTum;
  bool json = false;
};

using Sessions = std::map<std::string, SequencedPoses>;

nlohmann::json SessionsJson(const std::string& map, const Sessions& sessions) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& [name, poses] : sessions) {
    nlohmann::json rows = nlohmann::json::array();
    for (const auto& [sequence, pose] : poses) {
      const Eigen::Vector3d& t = pose.map_from_camera.translation();
      const Eigen::Quaterniond& q = pose.map_from_camera.rotation();
      rows.push_back({{"sequence", sequence},
                      {"timestamp_ns", pose.timestamp},
                      {"translation", {t.x(), t.y(), t.z()}},
                      {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}}});
    }
    list.push_back({{"session", IdOfName(name)}, {"count", rows.size()}, {"poses", rows}});
  }
  return {{"map", IdOfName(map)}, {"sessions", list}};
}

// A trajectory file is of one drive.
absl::StatusOr<SequencedPoses> OnlySession(const Sessions& sessions) {
  if (sessions.empty()) return SequencedPoses();
  if (sessions.size() == 1) return sessions.begin()->second;
  std::string names;
  for (const auto& [name, poses] : sessions) absl::StrAppend(&names, " ", IdOfName(name));
  return UsageError(absl::StrCat("the map has several sessions; choose one with --session:", names));
}

absl::Status PrintSession(const TrajectoryArguments& arguments, const SequencedPoses& poses,
                          const Console& console) {
  Trajectory trajectory = WithHoles(poses);
  if (arguments.format == TrajectoryFormat::kKitti && !poses.empty()) {
    uint64_t filled = 0;
    trajectory = WithoutHoles(poses, 1, poses.rbegin()->first, &filled);
    if (filled > 0)
      console.err << "semmap: " << filled << " frames have no pose; the last known one is repeated\n";
  }
  if (!arguments.output.empty()) return WriteTrajectory(arguments.output, trajectory, arguments.format);
  console.out << FormatTrajectory(trajectory, arguments.format);
  return absl::OkStatus();
}

absl::Status RunTrajectory(const TrajectoryArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  Client client(connection);
  SEMMAP_ASSIGN_OR_RETURN(const Sessions sessions,
                          FetchTrajectories(client, arguments.map, arguments.session));
  if (arguments.json) {
    console.out << SessionsJson(arguments.map, sessions).dump(2) << "\n";
    return absl::OkStatus();
  }
  SEMMAP_ASSIGN_OR_RETURN(const SequencedPoses poses, OnlySession(sessions));
  return PrintSession(arguments, poses, console);
}

}  // namespace

void AddTrajectoryCommand(CLI::App& parent, Action* action) {
  static const std::map<std::string, TrajectoryFormat> formats = {{"tum", TrajectoryFormat::kTum},
                                                                  {"kitti", TrajectoryFormat::kKitti}};
  CLI::App* command = parent.add_subcommand("trajectory", "Where a session drove, as the map has it now");
  auto arguments = std::make_shared<TrajectoryArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  AddServerOptions(*command, &arguments->server);
  command->add_option("--session", arguments->session, "Which session; needed when the map has several");
  command->add_option("--format", arguments->format, "tum|kitti; default tum")
      ->transform(CLI::CheckedTransformer(formats));
  CLI::Option* output = command->add_option("--output", arguments->output, "Write to a file");
  command->add_flag("--json", arguments->json, "Print JSON")->excludes(output);
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunTrajectory(*arguments, console); };
  });
}

}  // namespace semmap::client
