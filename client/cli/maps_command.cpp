// semmap maps: lists the maps of a server.

#include <memory>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/map_report.h"
#include "client/cli/server_options.h"
#include "client/cli/table.h"
#include "client/client.h"
#include "client/names.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct MapsArguments {
  ServerOptions server;
  bool json = false;
};

std::string MapsTable(const std::vector<v1::Map>& maps) {
  Table table({"NAME", "STATE", "KEYFRAMES", "POINTS", "VERSION", "UPDATED (UTC)"});
  for (const v1::Map& map : maps) {
    table.AddRow({IdOfName(map.name()), MapStateName(map.state()), absl::StrCat(map.keyframe_count()),
                  absl::StrCat(map.point_count()), absl::StrCat(map.version()),
                  FormatUtc(map.update_time().seconds())});
  }
  return table.empty() ? "no maps\n" : table.Format();
}

absl::Status RunMaps(const MapsArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<v1::Map> maps, Client(connection).ListMaps());
  if (!arguments.json) {
    console.out << MapsTable(maps);
    return absl::OkStatus();
  }
  nlohmann::json list = nlohmann::json::array();
  for (const v1::Map& map : maps) list.push_back(MapJson(map));
  console.out << nlohmann::json{{"maps", list}}.dump(2) << "\n";
  return absl::OkStatus();
}

}  // namespace

void AddMapsCommand(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("maps", "List the maps of the server");
  auto arguments = std::make_shared<MapsArguments>();
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunMaps(*arguments, console); };
  });
}

}  // namespace semmap::client
