// semmap relocalize: where pictures were taken.

#include <array>
#include <memory>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/frame_message.h"
#include "client/cli/relocalization_report.h"
#include "client/cli/rig_conversion.h"
#include "client/cli/server_options.h"
#include "client/cli/table.h"
#include "client/client.h"
#include "client/sources/camera_file.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct RelocalizeArguments {
  ServerOptions server;
  std::string map;
  std::string camera_file;
  std::vector<std::string> images;
  std::vector<std::string> right_images;
  std::vector<double> prior;    // x, y, z, radius
  std::vector<double> near;     // latitude, longitude, altitude if known
  double radius_m = 0;          // of `near`
  std::vector<double> heading;  // x, y, z, degrees
  bool json = false;
};

void FillPrior(const RelocalizeArguments& arguments, v1::RelocalizeRequest* request) {
  const auto fill = [](const std::vector<double>& values, v1::Vector3* vector) {
    vector->set_x(values[0]);
    vector->set_y(values[1]);
    vector->set_z(values[2]);
  };
  if (!arguments.prior.empty()) {
    fill(arguments.prior, request->mutable_prior()->mutable_position_in_map());
    request->mutable_prior()->set_radius_m(arguments.prior[3]);
  }
  if (!arguments.near.empty()) {
    v1::GeoPosition* position = request->mutable_prior()->mutable_geo_position();
    position->set_latitude_deg(arguments.near[0]);
    position->set_longitude_deg(arguments.near[1]);
    if (arguments.near.size() > 2) position->set_altitude_m(arguments.near[2]);
    request->mutable_prior()->set_radius_m(arguments.radius_m);
  }
  if (!arguments.heading.empty()) {
    fill(arguments.heading, request->mutable_prior()->mutable_heading_in_map());
    request->mutable_prior()->set_heading_tolerance_rad(arguments.heading[3] * std::numbers::pi / 180);
  }
}

absl::StatusOr<v1::RelocalizeRequest> RequestFor(const RelocalizeArguments& arguments, const CameraRig& rig,
                                                 size_t index) {
  v1::RelocalizeRequest request;
  request.set_map(arguments.map);
  *request.mutable_rig() = ToProto(rig);
  SourceFrame frame;
  SEMMAP_ASSIGN_OR_RETURN(frame.image, ReadSourceImage(arguments.images[index], false));
  if (!arguments.right_images.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(frame.right, ReadSourceImage(arguments.right_images[index], false));
  }
  SEMMAP_ASSIGN_OR_RETURN(*request.mutable_frame(), FrameMessage(std::move(frame)));
  FillPrior(arguments, &request);
  return request;
}

absl::Status RunRelocalize(const RelocalizeArguments& arguments, const Console& console) {
  const bool stereo = !arguments.right_images.empty();
  if (stereo && arguments.right_images.size() != arguments.images.size())
    return UsageError("--right needs as many images as there are left ones");
  SEMMAP_ASSIGN_OR_RETURN(
      const CameraRig rig,
      ReadCameraFile(arguments.camera_file, stereo ? SensorType::kStereo : SensorType::kMono));
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  Client client(connection);
  nlohmann::json all = nlohmann::json::array();
  for (size_t i = 0; i < arguments.images.size(); ++i) {
    SEMMAP_ASSIGN_OR_RETURN(const v1::RelocalizeRequest request, RequestFor(arguments, rig, i));
    SEMMAP_ASSIGN_OR_RETURN(const v1::RelocalizeResponse response, client.Relocalize(request));
    all.push_back(RelocalizationJson(arguments.images[i], response));
  }
  console.out << (arguments.json ? all.dump(2) + "\n" : RelocalizationTable(all));
  return absl::OkStatus();
}

}  // namespace

void AddRelocalizeCommand(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("relocalize", "Find out where in a map pictures were taken");
  auto arguments = std::make_shared<RelocalizeArguments>();
  command->add_option("image", arguments->images, "JPEG or PNG files, each a question of its own")
      ->required();
  command->add_option("--map", arguments->map, "Name of the map")->required();
  command->add_option("--camera", arguments->camera_file, "Camera file (YAML)")->required();
  command->add_option("--right", arguments->right_images,
                      "Right images of stereo pairs, in the order of the left ones");
  CLI::Option* prior =
      command->add_option("--prior", arguments->prior, "X,Y,Z,RADIUS: the camera is no further from there")
          ->delimiter(',')
          ->expected(4);
  CLI::Option* near = command
                          ->add_option("--near", arguments->near,
                                       "LATITUDE,LONGITUDE[,ALTITUDE]: it is near there, with --radius; for "
                                       "maps with an anchor")
                          ->delimiter(',')
                          ->expected(2, 3)
                          ->excludes(prior);
  CLI::Option* radius = command->add_option("--radius", arguments->radius_m, "Metres around --near")
                            ->check(CLI::PositiveNumber)
                            ->needs(near);
  near->needs(radius);
  command->add_option("--heading", arguments->heading, "X,Y,Z,DEGREES: it looks so far from there at most")
      ->delimiter(',')
      ->expected(4);
  AddServerOptions(*command, &arguments->server);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunRelocalize(*arguments, console); };
  });
}

}  // namespace semmap::client
