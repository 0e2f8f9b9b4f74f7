// semmap import: a file that semmap export wrote as a new map.

#include <fstream>
#include <memory>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/map_report.h"
#include "client/cli/operation_progress.h"
#include "client/cli/server_options.h"
#include "client/client.h"
#include "client/names.h"
#include "slam/common/sha256.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct ImportArguments {
  ServerOptions server;
  std::string file;
  std::string map;
  bool json = false;
};

absl::Status RunImport(const ImportArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string sha256, Sha256OfFile(arguments.file));
  std::ifstream file(arguments.file, std::ios::binary);
  const auto read = [&](std::span<char> room) -> absl::StatusOr<size_t> {
    file.read(room.data(), static_cast<std::streamsize>(room.size()));
    if (file.bad()) return absl::DataLossError(absl::StrCat(arguments.file, " cannot be read"));
    return static_cast<size_t>(file.gcount());
  };
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  SEMMAP_ASSIGN_OR_RETURN(const v1::Map map,
                          Client(connection).ImportMap(arguments.map, sha256, read, ShowOn(console)));
  if (arguments.json) {
    console.out << MapJson(map).dump(2) << "\n";
  } else {
    console.out << "imported " << IdOfName(map.name()) << ": " << map.keyframe_count() << " keyframes, "
                << map.point_count() << " points\n";
  }
  return absl::OkStatus();
}

}  // namespace

void AddImportCommand(CLI::App& parent, Action* action) {
  CLI::App* command =
      parent.add_subcommand("import", "Make a map of a file that export --format semmap wrote");
  auto arguments = std::make_shared<ImportArguments>();
  command->add_option("file,--file", arguments->file, "The file to read")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--map", arguments->map, "Name of the new map")->required();
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunImport(*arguments, console); };
  });
}

}  // namespace semmap::client
