// Asks a server where the pictures of a recording were taken, in a map made of another, and compares the
// answers with the truth, which both recordings know in one frame.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_format.h"
#include "client/cli/frame_message.h"
#include "client/cli/relocalization_report.h"
#include "client/cli/rig_conversion.h"
#include "client/client.h"
#include "client/names.h"
#include "client/sources/open_source.h"
#include "nlohmann/json.hpp"
#include "slam/common/status_macros.h"
#include "slam/evaluation/recall.h"
#include "slam/evaluation/statistics.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/geometry/alignment.h"
#include "tests/bench/bench_main.h"

namespace semmap::bench {
namespace {

constexpr double kWrong = 5.0;  // metres
// A picture shows a place of the map when a keyframe stood so near and looked so nearly the same way; it is
// from elsewhere when none stood within kFar.
constexpr double kNear = 8.0;
constexpr double kNearAngle = 45 * std::numbers::pi / 180;
constexpr double kFar = 30.0;

struct Arguments {
  std::string server = "localhost:50051";
  std::string map;
  std::string map_times;    // times.txt of the recording that became the map
  std::string map_truth;    // its poses in the common frame, KITTI's format
  std::string query;        // source
  std::string query_truth;  // in the common frame; one line for each frame
  SensorType sensor = SensorType::kMono;
  bool with_scale = false;
  int every = 1;
  int skip = 0;
  std::string answers;  // file to write
  std::string compare;  // answers of an earlier run
  bool json = false;
};

// One question and what became of it.
struct Answer {
  size_t frame = 0;
  v1::RelocalizeResponse response;
  PoseError error;  // FOUND only
  double distance_m = 0;
  bool in_map = false;
};

// Where the map's keyframes truly stood, and how to get there from the map.
struct MapTruth {
  Sim3 world_from_map;
  std::vector<SE3> world_from_keyframe;
};

absl::StatusOr<MapTruth> ReadMapTruth(const Arguments& arguments, client::Client& client) {
  SEMMAP_ASSIGN_OR_RETURN(Trajectory truth, ReadKittiTrajectory(arguments.map_truth));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<TimestampNs> times, ReadTimes(arguments.map_times));
  SEMMAP_RETURN_IF_ERROR(AttachTimes(times, &truth));
  std::map<TimestampNs, SE3> by_time;
  for (const StampedPose& pose : truth.poses) by_time.emplace(pose.timestamp, pose.map_from_camera);
  MapTruth result;
  std::vector<Eigen::Vector3d> in_map;
  std::vector<Eigen::Vector3d> in_world;
  v1::QueryKeyFramesRequest request;
  request.set_map(arguments.map);
  SEMMAP_RETURN_IF_ERROR(client.QueryKeyFrames(request, [&](const v1::KeyFrame& keyframe) {
    const auto pose = by_time.find(keyframe.timestamp_ns());
    if (pose == by_time.end()) return true;
    result.world_from_keyframe.push_back(pose->second);
    in_world.push_back(pose->second.translation());
    in_map.push_back(client::FromProto(keyframe.map_from_camera()).translation());
    return true;
  }));
  SEMMAP_ASSIGN_OR_RETURN(result.world_from_map, AlignPoints(in_map, in_world, arguments.with_scale));
  return result;
}

SE3 ToWorld(const Sim3& world_from_map, const SE3& map_from_camera) {
  return SE3(world_from_map.rigid.rotation() * map_from_camera.rotation(),
             world_from_map * map_from_camera.translation());
}

// Fills in how far the picture is from the map.
void Place(const MapTruth& map, const SE3& world_from_camera, Answer* answer) {
  answer->distance_m = std::numeric_limits<double>::infinity();
  for (const SE3& keyframe : map.world_from_keyframe) {
    const PoseError apart = ComparePoses(keyframe, world_from_camera);
    answer->distance_m = std::min(answer->distance_m, apart.translation_m);
    answer->in_map = answer->in_map || (apart.translation_m < kNear && apart.rotation_rad < kNearAngle);
  }
}

absl::StatusOr<std::vector<Answer>> Ask(const Arguments& arguments, const MapTruth& map,
                                        client::Client& client) {
  SEMMAP_ASSIGN_OR_RETURN(const std::unique_ptr<client::FrameSource> source,
                          client::OpenSource(arguments.query, {arguments.sensor, ""}));
  SEMMAP_ASSIGN_OR_RETURN(const Trajectory truth, ReadKittiTrajectory(arguments.query_truth));
  std::vector<Answer> answers;
  for (size_t frame = 0;; ++frame) {
    SEMMAP_ASSIGN_OR_RETURN(std::optional<client::SourceFrame> images, source->Next());
    if (!images) break;
    if (frame < static_cast<size_t>(arguments.skip) ||
        (frame - static_cast<size_t>(arguments.skip)) % static_cast<size_t>(arguments.every) != 0) {
      continue;
    }
    if (frame >= truth.poses.size()) return absl::InvalidArgumentError("the truth is too short");
    v1::RelocalizeRequest request;
    request.set_map(arguments.map);
    *request.mutable_rig() = client::ToProto(source->rig());
    SEMMAP_ASSIGN_OR_RETURN(*request.mutable_frame(), client::FrameMessage(std::move(*images)));
    Answer answer;
    answer.frame = frame;
    SEMMAP_ASSIGN_OR_RETURN(answer.response, client.Relocalize(request));
    const SE3& world_from_camera = truth.poses[frame].map_from_camera;
    if (answer.response.result() == v1::RELOCALIZE_RESULT_FOUND) {
      const SE3 found = client::FromProto(answer.response.map_from_camera());
      answer.error = ComparePoses(world_from_camera, ToWorld(map.world_from_map, found));
    }
    Place(map, world_from_camera, &answer);
    answers.push_back(std::move(answer));
  }
  return answers;
}

nlohmann::json Summarize(const std::vector<Answer>& answers) {
  size_t in_map = 0;
  size_t elsewhere = 0;
  size_t found_elsewhere = 0;
  size_t found = 0;
  size_t wrong = 0;
  std::vector<PoseError> errors;
  std::vector<double> times;
  std::vector<double> distances;
  std::map<std::string, int> results;
  for (const Answer& answer : answers) {
    const bool is_found = answer.response.result() == v1::RELOCALIZE_RESULT_FOUND;
    in_map += answer.in_map ? 1 : 0;
    elsewhere += answer.distance_m > kFar ? 1 : 0;
    found += is_found ? 1 : 0;
    found_elsewhere += is_found && answer.distance_m > kFar ? 1 : 0;
    wrong += is_found && answer.error.translation_m > kWrong ? 1 : 0;
    if (is_found && answer.in_map) {
      errors.push_back(answer.error);
      distances.push_back(answer.error.translation_m);
    }
    times.push_back(answer.response.processing_ms());
    ++results[client::ResultName(answer.response.result())];
  }
  const std::vector<double> recall = RecallAtThresholds(errors, in_map);
  return {{"queries", answers.size()},
          {"in_map", in_map},
          {"elsewhere", elsewhere},
          {"found", found},
          {"found_in_map", errors.size()},
          {"found_elsewhere", found_elsewhere},
          {"wrong_by_over_5m", wrong},
          {"share_0.25m_2deg", recall[0]},
          {"share_0.5m_5deg", recall[1]},
          {"share_5m_10deg", recall[2]},
          {"median_error_m", distances.empty() ? 0.0 : Percentile(distances, 0.5)},
          {"median_ms", times.empty() ? 0.0 : Percentile(times, 0.5)},
          {"p95_ms", times.empty() ? 0.0 : Percentile(times, 0.95)},
          {"results", results}};
}

void PrintTable(const nlohmann::json& s) {
  std::cout << absl::StrFormat("%8s %7s %7s %7s %7s %7s %10s %7s %8s %8s\n", "queries", "in map", "found",
                               "0.25/2", "0.5/5", "5/10", "elsewhere", "wrong", "ms", "p95 ms");
  std::cout << absl::StrFormat(
      "%8d %7d %7d %6.1f%% %6.1f%% %6.1f%% %7d/%-3d%6d %8.1f %8.1f\n", s["queries"].get<int>(),
      s["in_map"].get<int>(), s["found_in_map"].get<int>(), 100 * s["share_0.25m_2deg"].get<double>(),
      100 * s["share_0.5m_5deg"].get<double>(), 100 * s["share_5m_10deg"].get<double>(),
      s["found_elsewhere"].get<int>(), s["elsewhere"].get<int>(), s["wrong_by_over_5m"].get<int>(),
      s["median_ms"].get<double>(), s["p95_ms"].get<double>());
}

nlohmann::json AnswersJson(const std::vector<Answer>& answers) {
  nlohmann::json all = nlohmann::json::array();
  for (const Answer& answer : answers) {
    nlohmann::json json = client::RelocalizationJson(absl::StrFormat("%d", answer.frame), answer.response);
    json["distance_m"] = answer.distance_m;
    json["in_map"] = answer.in_map;
    if (answer.response.has_map_from_camera()) {
      json["error_m"] = answer.error.translation_m;
      json["error_deg"] = answer.error.rotation_rad * 180 / std::numbers::pi;
    }
    all.push_back(std::move(json));
  }
  return all;
}

// The greatest difference between two lists of answers: of any number of a pose, infinite where one has an
// answer that the other has not.
double Difference(const nlohmann::json& first, const nlohmann::json& second) {
  if (first.size() != second.size()) return std::numeric_limits<double>::infinity();
  double greatest = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    if (first[i]["image"] != second[i]["image"] || first[i]["result"] != second[i]["result"])
      return std::numeric_limits<double>::infinity();
    if (!first[i].contains("position")) continue;
    for (const char* part : {"position", "rotation"}) {
      for (size_t n = 0; n < first[i][part].size(); ++n) {
        greatest =
            std::max(greatest, std::abs(first[i][part][n].get<double>() - second[i][part][n].get<double>()));
      }
    }
  }
  return greatest;
}

absl::Status Run(const Arguments& arguments) {
  client::ConnectOptions options;
  options.address = arguments.server;
  SEMMAP_ASSIGN_OR_RETURN(const auto connection, client::Connection::Open(options));
  client::Client client(connection);
  SEMMAP_ASSIGN_OR_RETURN(const MapTruth map, ReadMapTruth(arguments, client));
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<Answer> answers, Ask(arguments, map, client));
  nlohmann::json summary = Summarize(answers);
  const nlohmann::json all = AnswersJson(answers);
  if (!arguments.answers.empty()) std::ofstream(arguments.answers) << all.dump(1) << "\n";
  if (!arguments.compare.empty()) {
    std::ifstream file(arguments.compare);
    const nlohmann::json earlier = nlohmann::json::parse(file, nullptr, false);
    if (earlier.is_discarded()) return absl::NotFoundError(arguments.compare + " cannot be read");
    summary["difference"] = Difference(earlier, all);
  }
  if (arguments.json) {
    std::cout << summary.dump(2) << "\n";
    return absl::OkStatus();
  }
  PrintTable(summary);
  if (summary.contains("difference"))
    std::cout << absl::StrFormat("greatest difference %.3g\n", summary["difference"].get<double>());
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  static const std::map<std::string, SensorType> sensors = {{"mono", SensorType::kMono},
                                                            {"stereo", SensorType::kStereo}};
  Arguments arguments;
  CLI::App app("Relocalization in a stored map, through the service");
  app.add_option("--server", arguments.server, "HOST:PORT");
  app.add_option("--map", arguments.map, "Name of the map")->required();
  app.add_option("--map-times", arguments.map_times, "times.txt of the recording that became the map")
      ->required();
  app.add_option("--map-truth", arguments.map_truth, "Its true poses, KITTI's format")->required();
  app.add_option("--query", arguments.query, client::SourceSpecHelp())->required();
  app.add_option("--query-truth", arguments.query_truth, "True poses of the pictures, in the same frame")
      ->required();
  app.add_option("--sensor", arguments.sensor, "mono|stereo; default mono")
      ->transform(CLI::CheckedTransformer(sensors));
  app.add_flag("--with-scale", arguments.with_scale, "Align by a similarity: maps of one camera");
  app.add_option("--every", arguments.every, "Ask about every so many-th picture")
      ->check(CLI::PositiveNumber);
  app.add_option("--skip", arguments.skip, "Leave out so many at first");
  app.add_option("--answers", arguments.answers, "Write all answers to this file (JSON)");
  app.add_option("--compare", arguments.compare, "Say how far they are from those in this file");
  app.add_flag("--json", arguments.json, "Print JSON instead of a table");
  return RunMain(app, "map_relocalization", argc, argv, [&] { return Run(arguments); });
}

}  // namespace
}  // namespace semmap::bench

int main(int argc, char** argv) { return semmap::bench::Main(argc, argv); }
