// semmap export: a map as a file.

#include <map>
#include <memory>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/download.h"
#include "client/cli/operation_progress.h"
#include "client/cli/point_filter_options.h"
#include "client/cli/server_options.h"
#include "client/cli/table.h"
#include "client/client.h"
#include "client/names.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct ExportArguments {
  ServerOptions server;
  std::string map;
  v1::MapFileFormat format = v1::MAP_FILE_FORMAT_PLY;
  std::string output;
  PointFilterOptions filter;
  bool json = false;
};

void Report(const ExportArguments& arguments, const v1::ExportMapResponse& file, const Console& console) {
  if (arguments.json) {
    console.out << nlohmann::json{{"map", IdOfName(arguments.map)},
                                  {"output", arguments.output},
                                  {"size_bytes", file.size_bytes()},
                                  {"sha256", absl::BytesToHexString(file.sha256())}}
                       .dump(2)
                << "\n";
  } else {
    console.out << "wrote " << arguments.output << ", " << FormatBytes(file.size_bytes()) << "\n";
  }
}

absl::Status RunExport(const ExportArguments& arguments, const Console& console) {
  v1::ExportMapRequest request;
  request.set_name(arguments.map);
  request.set_format(arguments.format);
  SEMMAP_ASSIGN_OR_RETURN(*request.mutable_filter(), FilterOf(arguments.filter));
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  Client client(connection);
  SEMMAP_ASSIGN_OR_RETURN(const Client::Export exported, client.ExportMap(request, ShowOn(console)));
  const absl::Status downloaded = Download(client, exported.file, arguments.output);
  // The server deletes the file by itself, only later.
  client.DeleteOperation(exported.operation).IgnoreError();
  SEMMAP_RETURN_IF_ERROR(downloaded);
  Report(arguments, exported.file, console);
  return absl::OkStatus();
}

}  // namespace

void AddExportCommand(CLI::App& parent, Action* action) {
  static const std::map<std::string, v1::MapFileFormat> formats = {{"semmap", v1::MAP_FILE_FORMAT_SEMMAP},
                                                                   {"ply", v1::MAP_FILE_FORMAT_PLY},
                                                                   {"pcd", v1::MAP_FILE_FORMAT_PCD},
                                                                   {"csv", v1::MAP_FILE_FORMAT_CSV},
                                                                   {"geojson", v1::MAP_FILE_FORMAT_GEOJSON}};
  CLI::App* command = parent.add_subcommand("export", "Write a map to a file");
  auto arguments = std::make_shared<ExportArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  command
      ->add_option(
          "--format", arguments->format,
          "ply|pcd|csv: points with their class, its colour and confidence; semmap: all there is of the map, "
          "for semmap import; geojson: points and trajectories in WGS84 of a map with an anchor; default ply")
      ->transform(CLI::CheckedTransformer(formats));
  command->add_option("--output", arguments->output, "The file to write")->required();
  AddServerOptions(*command, &arguments->server);
  AddPointFilterOptions(*command, &arguments->filter);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunExport(*arguments, console); };
  });
}

}  // namespace semmap::client
