// semmap watch: what changes in a map while vehicles drive.

#include <memory>

#include "absl/strings/str_format.h"
#include "client/cli/commands.h"
#include "client/cli/server_options.h"
#include "client/client.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct WatchArguments {
  ServerOptions server;
  std::string map;
  uint64_t after = 0;
  int count = 0;
  bool keyframes_only = false;
  bool json = false;
};

nlohmann::json PointsJson(const v1::MapPointColumns& points) {
  nlohmann::json list = nlohmann::json::array();
  for (int i = 0; i < points.ids_size(); ++i) {
    list.push_back(
        {{"id", points.ids(i)},
         {"position", {points.positions(3 * i), points.positions(3 * i + 1), points.positions(3 * i + 2)}},
         {"class", points.semantic_classes(i)},
         {"confidence", points.class_confidences(i)}});
  }
  return list;
}

nlohmann::json KeyFramesJson(const v1::WatchMapResponse& response) {
  nlohmann::json list = nlohmann::json::array();
  for (const v1::KeyFrame& keyframe : response.keyframes()) {
    const v1::Vector3& t = keyframe.map_from_camera().translation();
    const v1::Quaternion& q = keyframe.map_from_camera().rotation();
    list.push_back({{"id", keyframe.id()},
                    {"session", keyframe.session()},
                    {"timestamp_ns", keyframe.timestamp_ns()},
                    {"translation", {t.x(), t.y(), t.z()}},
                    {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}}});
  }
  return list;
}

// One line for each message, so that programs can follow.
std::string LineOf(const v1::WatchMapResponse& response, bool as_json) {
  if (as_json) {
    const nlohmann::json line = {
        {"version", response.map_version()},       {"reset", response.reset()},
        {"keyframes", KeyFramesJson(response)},    {"removed_keyframes", response.removed_keyframe_ids()},
        {"points", PointsJson(response.points())}, {"removed_points", response.removed_point_ids()}};
    return line.dump();
  }
  return absl::StrFormat("version %d%s: %d keyframes, %d removed; %d points, %d removed",
                         response.map_version(), response.reset() ? ", all anew" : "",
                         response.keyframes_size(), response.removed_keyframe_ids_size(),
                         response.points().ids_size(), response.removed_point_ids_size());
}

absl::Status RunWatch(const WatchArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  v1::WatchMapRequest request;
  request.set_map(arguments.map);
  request.set_after_version(arguments.after);
  request.set_keyframes_only(arguments.keyframes_only);
  int left = arguments.count;
  const absl::Status status = Client(connection).WatchMap(request, [&](const v1::WatchMapResponse& response) {
    if (response.points().positions_size() != 3 * response.points().ids_size()) return false;
    console.out << LineOf(response, arguments.json) << std::endl;
    return console.out.good() && --left != 0;
  });
  return arguments.count > 0 && left == 0 && absl::IsCancelled(status) ? absl::OkStatus() : status;
}

}  // namespace

void AddWatchCommand(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("watch", "Follow what changes in a map, a line for each message");
  auto arguments = std::make_shared<WatchArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  command->add_option("--after", arguments->after,
                      "Only what changed after this version; default: all there is first");
  command->add_option("--count", arguments->count, "End after so many messages; default: never")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--keyframes-only", arguments->keyframes_only, "No points");
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON, one object a line");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunWatch(*arguments, console); };
  });
}

}  // namespace semmap::client
