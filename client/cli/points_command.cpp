// semmap points: the points of a map.

#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/class_names.h"
#include "client/cli/commands.h"
#include "client/cli/point_filter_options.h"
#include "client/cli/server_options.h"
#include "client/cli/table.h"
#include "client/client.h"
#include "client/names.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

constexpr int64_t kRowsForPeople = 20;

struct PointsArguments {
  ServerOptions server;
  std::string map;
  PointFilterOptions filter;
  int64_t limit = -1;
  bool geographic = false;
  bool json = false;
};

struct Point {
  uint64_t id = 0;
  std::array<double, 3> position{};
  uint32_t semantic_class = 255;
  float confidence = 0;
  uint32_t observations = 0;
  int64_t first_seen_ns = 0;
  int64_t last_seen_ns = 0;
};

absl::StatusOr<v1::QueryMapPointsRequest> RequestOf(const PointsArguments& arguments) {
  v1::QueryMapPointsRequest request;
  request.set_map(MapName(arguments.map));
  SEMMAP_ASSIGN_OR_RETURN(*request.mutable_filter(), FilterOf(arguments.filter));
  if (arguments.geographic) request.set_coordinates(v1::COORDINATES_WGS84);
  for (const char* column :
       {"semantic_classes", "class_confidences", "observation_counts", "first_seen_ns", "last_seen_ns"}) {
    request.mutable_columns()->add_paths(column);
  }
  request.set_limit(arguments.limit >= 0 ? arguments.limit : (arguments.json ? 0 : kRowsForPeople));
  return request;
}

absl::Status Append(const v1::MapPointColumns& columns, std::vector<Point>* points) {
  const int count = columns.ids_size();
  if (columns.positions_size() != 3 * count || columns.semantic_classes_size() != count ||
      columns.class_confidences_size() != count || columns.observation_counts_size() != count ||
      columns.first_seen_ns_size() != count || columns.last_seen_ns_size() != count) {
    return absl::DataLossError("the server sent points whose columns differ in length");
  }
  for (int i = 0; i < count; ++i) {
    points->push_back({columns.ids(i),
                       {columns.positions(3 * i), columns.positions(3 * i + 1), columns.positions(3 * i + 2)},
                       columns.semantic_classes(i),
                       columns.class_confidences(i),
                       columns.observation_counts(i),
                       columns.first_seen_ns(i),
                       columns.last_seen_ns(i)});
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Point>> Query(Client& client, const v1::QueryMapPointsRequest& request) {
  std::vector<Point> points;
  absl::Status malformed;
  const absl::Status status = client.QueryMapPoints(request, [&](const v1::QueryMapPointsResponse& response) {
    malformed = Append(response.points(), &points);
    return malformed.ok();
  });
  SEMMAP_RETURN_IF_ERROR(malformed);
  SEMMAP_RETURN_IF_ERROR(status);
  return points;
}

nlohmann::json PointsJson(const std::string& map, const std::vector<Point>& points) {
  nlohmann::json list = nlohmann::json::array();
  for (const Point& point : points) {
    list.push_back({{"id", point.id},
                    {"position", point.position},
                    {"class", point.semantic_class},
                    {"class_name", ClassName(point.semantic_class)},
                    {"confidence", point.confidence},
                    {"observations", point.observations},
                    {"first_seen_ns", point.first_seen_ns},
                    {"last_seen_ns", point.last_seen_ns}});
  }
  return {{"map", IdOfName(map)}, {"count", points.size()}, {"points", list}};
}

std::string PointsTable(const std::vector<Point>& points, bool geographic) {
  Table table(geographic
                  ? std::vector<std::string>{"ID", "LONGITUDE", "LATITUDE", "ALTITUDE", "OBSERVATIONS",
                                             "CLASS", "CONFIDENCE"}
                  : std::vector<std::string>{"ID", "X", "Y", "Z", "OBSERVATIONS", "CLASS", "CONFIDENCE"});
  const int decimals = geographic ? 8 : 3;
  for (const Point& point : points) {
    table.AddRow({absl::StrCat(point.id), absl::StrFormat("%.*f", decimals, point.position[0]),
                  absl::StrFormat("%.*f", decimals, point.position[1]),
                  absl::StrFormat("%.3f", point.position[2]), absl::StrCat(point.observations),
                  ClassName(point.semantic_class), absl::StrFormat("%.2f", point.confidence)});
  }
  return table.empty() ? "no points\n" : table.Format();
}

absl::Status RunPoints(const PointsArguments& arguments, const Console& console) {
  SEMMAP_ASSIGN_OR_RETURN(const v1::QueryMapPointsRequest request, RequestOf(arguments));
  SEMMAP_ASSIGN_OR_RETURN(const std::shared_ptr<Connection> connection, Connect(arguments.server));
  Client client(connection);
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<Point> points, Query(client, request));
  console.out << (arguments.json ? PointsJson(arguments.map, points).dump(2) + "\n"
                                 : PointsTable(points, arguments.geographic));
  if (!arguments.json && request.limit() > 0 && points.size() == static_cast<size_t>(request.limit())) {
    console.err << "semmap: the first " << points.size() << " points; --limit 0 for all\n";
  }
  return absl::OkStatus();
}

}  // namespace

void AddPointsCommand(CLI::App& parent, Action* action) {
  CLI::App* command = parent.add_subcommand("points", "Points of a map");
  auto arguments = std::make_shared<PointsArguments>();
  command->add_option("map,--map", arguments->map, "Name of the map")->required();
  AddServerOptions(*command, &arguments->server);
  AddPointFilterOptions(*command, &arguments->filter);
  command->add_option("--limit", arguments->limit, "At most so many, 0: all; default 20, with --json all")
      ->check(CLI::NonNegativeNumber);
  command->add_flag(
      "--wgs84", arguments->geographic,
      "Positions as longitude and latitude in degrees and altitude in metres; the map must have an anchor");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, action] {
    *action = [arguments](const Console& console) { return RunPoints(*arguments, console); };
  });
}

}  // namespace semmap::client
