// semmap map update|anchor: what is said about a map.

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/map_report.h"
#include "client/cli/server_options.h"
#include "client/client.h"
#include "client/names.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct UpdateArguments {
  ServerOptions server;
  std::string map;
  std::optional<std::string> display_name;
  std::vector<std::string> labels;  // KEY=VALUE; without a value: taken away
  bool json = false;
};

struct AnchorArguments {
  ServerOptions server;
  std::string map;
  double latitude_deg = 0;
  double longitude_deg = 0;
  double altitude_m = 0;
  double heading_deg = 0;
  double scale = 1;
  bool remove = false;
  bool json = false;
};

absl::Status Print(const v1::Map& map, bool json, const Console& console) {
  console.out << (json ? MapJson(map).dump(2) : absl::StrCat("updated ", IdOfName(map.name()))) << "\n";
  return absl::OkStatus();
}

absl::Status ApplyLabel(const std::string& label, v1::Map* map) {
  const size_t equals = label.find('=');
  if (equals == 0 || equals == std::string::npos) {
    return UsageError(absl::StrCat("--label ", label, ": must be KEY=VALUE"));
  }
  const std::string value = label.substr(equals + 1);
  if (value.empty()) {
    map->mutable_labels()->erase(label.substr(0, equals));
  } else {
    (*map->mutable_labels())[label.substr(0, equals)] = value;
  }
  return absl::OkStatus();
}

absl::Status RunUpdate(const UpdateArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  Client client(connection);
  // With its etag, so that labels somebody else changes meanwhile are not lost.
  SEMMAP_ASSIGN_OR_RETURN(v1::Map map, client.GetMap(arguments.map));
  std::vector<std::string> paths;
  if (arguments.display_name) {
    map.set_display_name(*arguments.display_name);
    paths.emplace_back("display_name");
  }
  for (const std::string& label : arguments.labels) SEMMAP_RETURN_IF_ERROR(ApplyLabel(label, &map));
  if (!arguments.labels.empty()) paths.emplace_back("labels");
  if (paths.empty()) return UsageError("nothing to change: give --display-name or --label");
  SEMMAP_ASSIGN_OR_RETURN(map, client.UpdateMap(map, paths));
  return Print(map, arguments.json, console);
}

// The axes of a map whose first camera stands level: x right, y down, z in the direction of the heading.
Eigen::Quaterniond EnuFromLevelMap(double heading_deg) {
  const double heading = heading_deg * std::numbers::pi / 180;
  Eigen::Matrix3d enu_from_map;
  enu_from_map.col(0) = Eigen::Vector3d(std::cos(heading), -std::sin(heading), 0);
  enu_from_map.col(1) = -Eigen::Vector3d::UnitZ();
  enu_from_map.col(2) = Eigen::Vector3d(std::sin(heading), std::cos(heading), 0);
  return Eigen::Quaterniond(enu_from_map);
}

v1::GeoAnchor AnchorOf(const AnchorArguments& arguments) {
  v1::GeoAnchor anchor;
  anchor.mutable_origin()->set_latitude_deg(arguments.latitude_deg);
  anchor.mutable_origin()->set_longitude_deg(arguments.longitude_deg);
  anchor.mutable_origin()->set_altitude_m(arguments.altitude_m);
  anchor.mutable_enu_from_map()->set_scale(arguments.scale);
  const Eigen::Quaterniond rotation = EnuFromLevelMap(arguments.heading_deg);
  v1::Quaternion* q = anchor.mutable_enu_from_map()->mutable_pose()->mutable_rotation();
  q->set_x(rotation.x());
  q->set_y(rotation.y());
  q->set_z(rotation.z());
  q->set_w(rotation.w());
  return anchor;
}

absl::Status RunAnchor(const AnchorArguments& arguments, const Console& console) {
  v1::Map map;
  map.set_name(arguments.map);
  if (!arguments.remove) *map.mutable_anchor() = AnchorOf(arguments);
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(map, Client(connection).UpdateMap(map, {"anchor"}));
  return Print(map, arguments.json, console);
}

void AddUpdate(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("update", "Say what a map is");
  auto arguments = std::make_shared<UpdateArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  command->add_option("--display-name", arguments->display_name, "A name for people");
  command->add_option("--label", arguments->labels, "KEY=VALUE; KEY= takes one away; repeatable");
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunUpdate(*arguments, console); };
  });
}

void AddAnchor(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("anchor", "Say where on Earth a map lies");
  auto arguments = std::make_shared<AnchorArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  CLI::Option* remove = command->add_flag("--remove", arguments->remove, "Take the anchor away");
  command->add_option("--latitude", arguments->latitude_deg, "Of the map's origin, degrees")
      ->check(CLI::Range(-90.0, 90.0))
      ->excludes(remove);
  command->add_option("--longitude", arguments->longitude_deg, "Of the map's origin, degrees")
      ->check(CLI::Range(-180.0, 180.0))
      ->excludes(remove);
  command->add_option("--altitude", arguments->altitude_m, "Above the ellipsoid, metres; default 0")
      ->excludes(remove);
  command
      ->add_option("--heading", arguments->heading_deg,
                   "Where the map's z axis, the first camera's view, points: degrees from north over east")
      ->excludes(remove);
  command->add_option("--scale", arguments->scale, "Metres in the map's unit of length; default 1")
      ->check(CLI::PositiveNumber)
      ->excludes(remove);
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action, command] {
    if (!arguments->remove && (command->count("--latitude") == 0 || command->count("--longitude") == 0)) {
      throw CLI::RequiredError("--latitude and --longitude, or --remove");
    }
    *action = [arguments](const Console& console) { return RunAnchor(*arguments, console); };
  });
}

}  // namespace

void AddMapUpdateCommands(CLI::App& map_command, Action* action) {
  AddUpdate(map_command, action);
  AddAnchor(map_command, action);
}

}  // namespace semmap::client
