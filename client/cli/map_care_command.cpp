// semmap map rename|copy|check|repair: care for a map.

#include <memory>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/map_report.h"
#include "client/cli/operation_progress.h"
#include "client/cli/server_options.h"
#include "client/cli/table.h"
#include "client/client.h"
#include "client/names.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct CareArguments {
  ServerOptions server;
  std::string map;
  std::string new_name;
  bool json = false;
};

using Run = absl::Status (*)(const CareArguments&, const Console&);

absl::Status Print(const CareArguments& arguments, const char* done, const v1::Map& map,
                   const Console& console) {
  if (arguments.json) {
    console.out << MapJson(map).dump(2) << "\n";
  } else {
    console.out << done << " " << IdOfName(arguments.map) << " to " << IdOfName(map.name()) << "\n";
  }
  return absl::OkStatus();
}

absl::Status RunRename(const CareArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const v1::Map map, Client(connection).RenameMap(arguments.map, arguments.new_name));
  return Print(arguments, "renamed", map, console);
}

absl::Status RunCopy(const CareArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const v1::Map map,
                          Client(connection).CopyMap(arguments.map, arguments.new_name, ShowOn(console)));
  return Print(arguments, "copied", map, console);
}

// A map with problems is a failure, for the sake of scripts.
absl::Status Conclude(const CareArguments& arguments, const v1::CheckMapResponse& response,
                      const Console& console) {
  console.out << (arguments.json ? MapCheckJson(response).dump(2) + "\n" : MapCheckTable(response));
  if (response.problems().empty()) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat("map ", IdOfName(arguments.map), " is not sound"));
}

absl::Status RunCheck(const CareArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const v1::CheckMapResponse response,
                          Client(connection).CheckMap(arguments.map, ShowOn(console)));
  return Conclude(arguments, response, console);
}

absl::Status RunRepair(const CareArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const v1::CheckMapResponse response,
                          Client(connection).RepairMap(arguments.map, ShowOn(console)));
  return Conclude(arguments, response, console);
}

void AddOne(CLI::App& parent, const char* name, const char* help, bool with_new_name, Run run,
            Action* action) {
  CLI::App* command = parent.add_subcommand(name, help);
  auto arguments = std::make_shared<CareArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  if (with_new_name) command->add_option("new-name,--to", arguments->new_name, "The new name")->required();
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, run, action] {
    *action = [arguments, run](const Console& console) { return run(*arguments, console); };
  });
}

}  // namespace

void AddMapCareCommands(CLI::App& map_command, Action* action) {
  AddOne(map_command, "rename", "Give a map another name", true, RunRename, action);
  AddOne(map_command, "copy", "Make another map of the same contents", true, RunCopy, action);
  AddOne(map_command, "check", "Look for contradictions in what is stored of a map", false, RunCheck, action);
  AddOne(map_command, "repair", "Remove what a check finds wrong, then check again", false, RunRepair,
         action);
}

}  // namespace semmap::client
