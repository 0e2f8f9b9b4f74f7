// semmap map show|delete: one map.

#include <memory>

#include "client/cli/commands.h"
#include "client/cli/map_report.h"
#include "client/cli/server_options.h"
#include "client/client.h"
#include "client/names.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct MapArguments {
  ServerOptions server;
  std::string map;
  bool json = false;
};

absl::Status RunShow(const MapArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const v1::MapSummary summary, Client(connection).GetMapSummary(arguments.map));
  console.out << (arguments.json ? MapSummaryJson(summary).dump(2) + "\n" : MapSummaryTable(summary));
  return absl::OkStatus();
}

absl::Status RunDelete(const MapArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_RETURN_IF_ERROR(Client(connection).DeleteMap(arguments.map));
  if (arguments.json) {
    console.out << nlohmann::json{{"deleted", IdOfName(arguments.map)}}.dump(2) << "\n";
  } else {
    console.out << "deleted " << IdOfName(arguments.map) << "\n";
  }
  return absl::OkStatus();
}

void AddOne(CLI::App& parent, const char* name, const char* help,
            absl::Status (*run)(const MapArguments&, const Console&), Action* action) {
  CLI::App* command = parent.add_subcommand(name, help);
  auto arguments = std::make_shared<MapArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, run, action] {
    *action = [arguments, run](const Console& console) { return run(*arguments, console); };
  });
}

}  // namespace

void AddMapCommand(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand(
      "map", "Show, describe, check, copy, rename, join, optimize, prune or delete a map");
  command->require_subcommand(1);
  AddOne(*command, "show", "What a map holds, in figures", RunShow, action);
  AddOne(*command, "delete", "Delete a map with its contents and sessions", RunDelete, action);
  AddMapUpdateCommands(*command, action);
  AddMapCareCommands(*command, action);
  AddMapReworkCommands(*command, action);
}

}  // namespace semmap::client
