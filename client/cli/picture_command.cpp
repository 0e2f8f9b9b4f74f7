// semmap picture: a map as a picture, by class.

#include <map>
#include <memory>

#include "absl/strings/str_cat.h"
#include "client/cli/commands.h"
#include "client/cli/map_picture.h"
#include "client/cli/map_scene.h"
#include "client/cli/point_filter_options.h"
#include "client/cli/server_options.h"
#include "client/cli/session_trajectory.h"
#include "client/cli/write_png.h"
#include "client/client.h"
#include "client/names.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

struct PictureArguments {
  ServerOptions server;
  std::string map;
  std::string output;
  PointFilterOptions filter;
  MapPictureOptions picture;
  bool json = false;
};

absl::Status FetchPoints(Client& client, const PictureArguments& arguments, MapScene* scene) {
  v1::QueryMapPointsRequest request;
  request.set_map(arguments.map);
  SEMMAP_ASSIGN_OR_RETURN(*request.mutable_filter(), FilterOf(arguments.filter));
  request.mutable_columns()->add_paths("semantic_classes");
  absl::Status malformed;
  const absl::Status status = client.QueryMapPoints(request, [&](const v1::QueryMapPointsResponse& response) {
    const v1::MapPointColumns& points = response.points();
    if (points.positions_size() != 3 * points.semantic_classes_size()) {
      malformed = absl::DataLossError("the server sent points whose columns differ in length");
      return false;
    }
    for (int i = 0; i < points.semantic_classes_size(); ++i) {
      const Eigen::Vector3d position(points.positions(3 * i), points.positions(3 * i + 1),
                                     points.positions(3 * i + 2));
      scene->points.push_back({position.cast<float>(), static_cast<uint8_t>(points.semantic_classes(i))});
    }
    return true;
  });
  SEMMAP_RETURN_IF_ERROR(malformed);
  return status;
}

// Cameras look along the road: on average their y axis points down.
Eigen::Vector3d UpOf(const std::map<std::string, SequencedPoses>& sessions) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const auto& [name, poses] : sessions) {
    for (const auto& [sequence, pose] : poses) {
      up -= pose.map_from_camera.rotation() * Eigen::Vector3d::UnitY();
    }
  }
  return up.norm() > 0 ? Eigen::Vector3d(up.normalized()) : Eigen::Vector3d(-Eigen::Vector3d::UnitY());
}

absl::Status FetchPaths(Client& client, const PictureArguments& arguments, MapScene* scene) {
  SEMMAP_ASSIGN_OR_RETURN(const auto sessions, FetchTrajectories(client, arguments.map, ""));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<v1::Session> known, [&] {
    v1::ListSessionsRequest request;
    request.set_map(arguments.map);
    return client.ListSessions(request);
  }());
  std::map<std::string, std::string> vehicles;
  for (const v1::Session& session : known) vehicles[session.name()] = session.vehicle_id();
  for (const auto& [name, poses] : sessions) {
    scene->paths.push_back({vehicles[name], {}});
    for (const auto& [sequence, pose] : poses) {
      scene->paths.back().positions.push_back(pose.map_from_camera.translation());
    }
  }
  scene->up = UpOf(sessions);
  return absl::OkStatus();
}

absl::Status Write(const PictureArguments& arguments, const GroundScene& scene) {
  MapPictureOptions options = arguments.picture;
  options.title = absl::StrCat("map ", IdOfName(arguments.map), ": ", scene.points.size(), " points");
  if (scene.left_out > 0) {
    absl::StrAppend(&options.title, " (", scene.left_out, " far off are left out)");
  }
  try {
    return WritePng(arguments.output, DrawMapPicture(scene, options));
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("the map cannot be drawn: ", error.what()));
  }
}

absl::Status RunPicture(const PictureArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  Client client(connection);
  MapScene scene;
  SEMMAP_RETURN_IF_ERROR(FetchPoints(client, arguments, &scene));
  SEMMAP_RETURN_IF_ERROR(FetchPaths(client, arguments, &scene));
  const GroundScene drawn = PutOnGround(scene);
  SEMMAP_RETURN_IF_ERROR(Write(arguments, drawn));
  if (arguments.json) {
    console.out << nlohmann::json{{"map", IdOfName(arguments.map)},
                                  {"output", arguments.output},
                                  {"points", drawn.points.size()},
                                  {"left_out", drawn.left_out},
                                  {"paths", drawn.paths.size()}}
                       .dump(2)
                << "\n";
  } else {
    console.out << "wrote " << arguments.output << ": " << drawn.points.size() << " points, "
                << drawn.paths.size() << " paths\n";
  }
  return absl::OkStatus();
}

}  // namespace

void AddPictureCommand(CLI::App& parent, Action* action) {
  static const std::map<std::string, MapView> views = {
      {"top", MapView::kTop}, {"perspective", MapView::kPerspective}, {"both", MapView::kBoth}};
  constexpr int kDefaultMinObservations = 3;
  CLI::App* command =
      parent.add_subcommand("picture", "Draw a map: points by class, and where vehicles drove");
  auto arguments = std::make_shared<PictureArguments>();
  arguments->filter.min_observations = kDefaultMinObservations;
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  command->add_option("--output", arguments->output, "The PNG file to write")->required();
  command->add_option("--view", arguments->picture.view, "top|perspective|both; default both")
      ->transform(CLI::CheckedTransformer(views));
  command->add_option("--width", arguments->picture.width, "Of the picture, pixels; default 1800")
      ->check(CLI::Range(600, 10000));
  AddServerOptions(*command, &arguments->server);
  AddPointFilterOptions(*command, &arguments->filter);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunPicture(*arguments, console); };
  });
}

}  // namespace semmap::client
