// semmap keyframes: the keyframes of a map.

#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/area_options.h"
#include "client/cli/commands.h"
#include "client/cli/server_options.h"
#include "client/cli/table.h"
#include "client/client.h"
#include "client/names.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"
#include "slam/evaluation/line_reader.h"

namespace semmap::client {
namespace {

struct KeyFramesArguments {
  ServerOptions server;
  std::string map;
  std::string session;
  AreaOptions area;
  int64_t limit = 0;
  bool json = false;
};

absl::StatusOr<std::vector<v1::KeyFrame>> Query(const KeyFramesArguments& arguments) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  v1::QueryKeyFramesRequest request;
  request.set_map(MapName(arguments.map));
  if (!arguments.session.empty()) request.set_session(SessionName(arguments.session));
  v1::Area area;
  if (FillArea(arguments.area, &area)) *request.mutable_area() = area;
  const auto limit = static_cast<size_t>(arguments.limit);
  std::vector<v1::KeyFrame> keyframes;
  const absl::Status status = Client(connection).QueryKeyFrames(request, [&](const v1::KeyFrame& keyframe) {
    keyframes.push_back(keyframe);
    return limit == 0 || keyframes.size() < limit;
  });
  const bool stopped_here = absl::IsCancelled(status) && limit != 0 && keyframes.size() == limit;
  if (!stopped_here) SEMMAP_RETURN_IF_ERROR(status);
  return keyframes;
}

nlohmann::json KeyFrameJson(const v1::KeyFrame& keyframe) {
  const v1::Vector3& t = keyframe.map_from_camera().translation();
  const v1::Quaternion& q = keyframe.map_from_camera().rotation();
  return {{"id", keyframe.id()},
          {"session", IdOfName(keyframe.session())},
          {"sequence", keyframe.sequence()},
          {"timestamp_ns", keyframe.timestamp_ns()},
          {"translation", {t.x(), t.y(), t.z()}},
          {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}},
          {"parent", keyframe.parent_id()},
          {"keypoints", keyframe.keypoint_count()},
          {"observations", keyframe.observation_count()}};
}

std::string KeyFramesTable(const std::vector<v1::KeyFrame>& keyframes) {
  Table table({"ID", "SESSION", "SEQUENCE", "TIME S", "X", "Y", "Z", "PARENT", "KEYPOINTS", "OBSERVATIONS"});
  for (const v1::KeyFrame& keyframe : keyframes) {
    const v1::Vector3& t = keyframe.map_from_camera().translation();
    table.AddRow({absl::StrCat(keyframe.id()), IdOfName(keyframe.session()),
                  absl::StrCat(keyframe.sequence()), FormatSeconds(keyframe.timestamp_ns()),
                  absl::StrFormat("%.3f", t.x()), absl::StrFormat("%.3f", t.y()),
                  absl::StrFormat("%.3f", t.z()), absl::StrCat(keyframe.parent_id()),
                  absl::StrCat(keyframe.keypoint_count()), absl::StrCat(keyframe.observation_count())});
  }
  return table.empty() ? "no keyframes\n" : table.Format();
}

absl::Status RunKeyFrames(const KeyFramesArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<v1::KeyFrame> keyframes, Query(arguments));
  if (!arguments.json) {
    console.out << KeyFramesTable(keyframes);
    return absl::OkStatus();
  }
  nlohmann::json list = nlohmann::json::array();
  for (const v1::KeyFrame& keyframe : keyframes) list.push_back(KeyFrameJson(keyframe));
  console.out << nlohmann::json{{"map", IdOfName(arguments.map)},
                                {"count", keyframes.size()},
                                {"keyframes", list}}
                     .dump(2)
              << "\n";
  return absl::OkStatus();
}

}  // namespace

void AddKeyFramesCommand(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("keyframes", "Keyframes of a map");
  auto arguments = std::make_shared<KeyFramesArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  AddServerOptions(*command, &arguments->server);
  AddAreaOptions(*command, &arguments->area);
  command->add_option("--session", arguments->session, "Only of this session");
  command->add_option("--limit", arguments->limit, "At most so many; default all")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunKeyFrames(*arguments, console); };
  });
}

}  // namespace semmap::client
