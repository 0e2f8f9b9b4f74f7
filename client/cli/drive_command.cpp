// semmap drive: plays a recording to a server as a vehicle would.

#include <map>
#include <memory>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/drive_session.h"
#include "client/sources/open_source.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct DriveArguments {
  DriveSessionOptions session;
  std::string source;
  SourceOptions source_options;
};

void AddRecordingOptions(CLI::App& command, DriveArguments* arguments) {
  static const std::map<std::string, SensorType> sensors = {
      {"mono", SensorType::kMono}, {"stereo", SensorType::kStereo}, {"rgbd", SensorType::kRgbd}};
  command.add_option("--source", arguments->source, SourceSpecHelp())
      ->required()
      ->check([](const std::string& spec) {
        return IsSourceSpec(spec) ? std::string() : absl::StrCat("is not one of ", SourceSpecHelp());
      });
  command.add_option("--sensor", arguments->source_options.sensor, "mono|stereo|rgbd")
      ->required()
      ->transform(CLI::CheckedTransformer(sensors));
  command.add_option("--camera", arguments->source_options.camera_file, "Camera file (YAML)");
  command.add_option("--frames", arguments->session.max_frames, "Stop after so many frames");
}

absl::Status RunDrive(const DriveArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<FrameSource> source,
                          OpenSource(arguments.source, arguments.source_options));
  return DriveSession(*source, arguments.session, console);
}

}  // namespace

void AddDriveCommand(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("drive", "Play a recording to the server as a vehicle would");
  auto arguments = std::make_shared<DriveArguments>();
  AddRecordingOptions(*command, arguments.get());
  AddDriveSessionOptions(*command, &arguments->session);
  command->get_option("--map")->required();
  command->get_option("--vehicle")->required();
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunDrive(*arguments, console); };
  });
}

}  // namespace semmap::client
