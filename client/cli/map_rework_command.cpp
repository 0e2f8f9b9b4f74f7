// semmap map merge|optimize|prune: make a stored map over.

#include <cstdint>
#include <memory>
#include <string>

#include "client/cli/commands.h"
#include "client/cli/map_rework_report.h"
#include "client/cli/operation_progress.h"
#include "client/cli/server_options.h"
#include "client/client.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct ReworkArguments {
  ServerOptions server;
  std::string map;
  std::string source;
  bool delete_source = false;
  bool dry_run = false;
  int iterations = 0;
  int64_t max_keyframes = 0;
  int64_t max_points = 0;
  bool json = false;
};

using Run = absl::Status (*)(const ReworkArguments&, const Console&);

void Print(const ReworkArguments& arguments, const nlohmann::json& json, const std::string& table,
           const Console& console) {
  console.out << (arguments.json ? json.dump(2) + "\n" : table);
}

absl::Status RunMerge(const ReworkArguments& arguments, const Console& console) {
  v1::MergeMapsRequest request;
  request.set_target(arguments.map);
  request.set_source(arguments.source);
  request.set_delete_source(arguments.delete_source);
  request.set_validate_only(arguments.dry_run);
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const v1::MergeMapsResponse response,
                          Client(connection).MergeMaps(request, ShowOn(console)));
  Print(arguments, MergeJson(response, arguments.dry_run), MergeTable(response, arguments.dry_run), console);
  return absl::OkStatus();
}

absl::Status RunOptimize(const ReworkArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(
      const Client::Optimized optimized,
      Client(connection).OptimizeMap(arguments.map, arguments.iterations, ShowOn(console)));
  Print(arguments, OptimizeJson(optimized), OptimizeTable(optimized), console);
  return absl::OkStatus();
}

absl::Status RunPrune(const ReworkArguments& arguments, const Console& console) {
  if (arguments.max_keyframes == 0 && arguments.max_points == 0)
    return UsageError("--max-keyframes or --max-points must be given");
  v1::PruneMapRequest request;
  request.set_name(arguments.map);
  request.set_max_keyframes(arguments.max_keyframes);
  request.set_max_points(arguments.max_points);
  request.set_validate_only(arguments.dry_run);
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const Client::Pruned pruned, Client(connection).PruneMap(request, ShowOn(console)));
  Print(arguments, PruneJson(pruned, arguments.dry_run), PruneTable(pruned, arguments.dry_run), console);
  return absl::OkStatus();
}

CLI::App* AddOne(CLI::App& parent, const char* name, const char* help, Run run,
                 const std::shared_ptr<ReworkArguments>& arguments, Action* action) {
  CLI::App* command = parent.add_subcommand(name, help);
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, run, action] {
    *action = [arguments, run](const Console& console) { return run(*arguments, console); };
  });
  return command;
}

void AddMerge(CLI::App& parent, Action* action) {
  const auto arguments = std::make_shared<ReworkArguments>();
  CLI::App* command =
      AddOne(parent, "merge", "Make one map of two that have places in common", RunMerge, arguments, action);
  command->add_option("target,--target", arguments->map, "The map that stays, with its frame")->required();
  command->add_option("source,--source", arguments->source, "The map that is joined to it")->required();
  command->add_flag("--delete-source", arguments->delete_source, "Delete the source when all is stored");
  command->add_flag("--dry-run", arguments->dry_run, "Only say what the maps have in common");
}

void AddOptimize(CLI::App& parent, Action* action) {
  const auto arguments = std::make_shared<ReworkArguments>();
  CLI::App* command = AddOne(parent, "optimize", "Adjust all keyframes and points of a map together",
                             RunOptimize, arguments, action);
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  command->add_option("--iterations", arguments->iterations, "At most so many; 0: the server's choice")
      ->check(CLI::Range(0, 1000));
}

void AddPrune(CLI::App& parent, Action* action) {
  const auto arguments = std::make_shared<ReworkArguments>();
  CLI::App* command = AddOne(parent, "prune", "Drop keyframes and points that tell least, to a budget",
                             RunPrune, arguments, action);
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  command->add_option("--max-keyframes", arguments->max_keyframes, "Keep at most so many; 0: all")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--max-points", arguments->max_points, "Keep at most so many; 0: all")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--dry-run", arguments->dry_run, "Only count");
}

}  // namespace

void AddMapReworkCommands(CLI::App& map_command, Action* action) {
  AddMerge(map_command, action);
  AddOptimize(map_command, action);
  AddPrune(map_command, action);
}

}  // namespace semmap::client
