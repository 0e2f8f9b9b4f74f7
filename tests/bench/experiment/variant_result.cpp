#include "tests/bench/experiment/variant_result.h"

#include "absl/strings/str_cat.h"

namespace semmap::bench {
namespace {

nlohmann::json OrNull(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

std::optional<double> Optional(const nlohmann::json& json) {
  return json.is_null() ? std::nullopt : std::optional<double>(json.get<double>());
}

nlohmann::json ToJson(const MapCensus::Group& group) {
  return {{"points", group.points},
          {"on_traffic_vehicles", group.on_traffic_vehicles},
          {"on_pedestrians", group.on_pedestrians},
          {"on_parked_vehicles", group.on_parked_vehicles},
          {"on_sky", group.on_sky}};
}

MapCensus::Group GroupFromJson(const nlohmann::json& json) {
  return {json.at("points"), json.at("on_traffic_vehicles"), json.at("on_pedestrians"),
          json.at("on_parked_vehicles"), json.at("on_sky")};
}

nlohmann::json ToJson(const MapCensus& census) {
  nlohmann::json json = {{"all", ToJson(census.all)},
                         {"active", ToJson(census.active)},
                         {"keypoints", census.keypoints},
                         {"keypoints_on_traffic", census.keypoints_on_traffic}};
  nlohmann::json& classes = json["classes"] = nlohmann::json::object();
  for (size_t id = 0; id < census.classes.size(); ++id) {
    const MapCensus::ClassTally& tally = census.classes[id];
    if (tally.points == 0) continue;
    classes[std::string(kSemanticClasses[id].name)] = {{"points", tally.points},
                                                       {"correct", tally.correct},
                                                       {"labels", tally.labels},
                                                       {"correct_labels", tally.correct_labels}};
  }
  return json;
}

MapCensus CensusFromJson(const nlohmann::json& json) {
  MapCensus census;
  census.all = GroupFromJson(json.at("all"));
  census.active = GroupFromJson(json.at("active"));
  census.keypoints = json.at("keypoints");
  census.keypoints_on_traffic = json.at("keypoints_on_traffic");
  for (const auto& [name, tally] : json.at("classes").items()) {
    const auto id = FindSemanticClass(name);
    if (!id) continue;
    census.classes[*id] = {tally.at("points"), tally.at("correct"), tally.at("labels"),
                           tally.at("correct_labels")};
  }
  return census;
}

}  // namespace

nlohmann::json ToJson(const VariantResult& result) {
  nlohmann::json json = {{"route", result.route},
                         {"traffic_seed", result.traffic_seed},
                         {"run", result.run},
                         {"variant", result.variant},
                         {"frames", result.frames},
                         {"tracked", result.tracked},
                         {"duration_s", result.duration_s},
                         {"length_m", result.length_m},
                         {"mape_percent", OrNull(result.mape_percent)},
                         {"ate_m", OrNull(result.ate_m)},
                         {"keyframes", result.keyframes},
                         {"points", result.points},
                         {"loops", result.loops},
                         {"recoveries", result.recoveries},
                         {"track_ms", result.track_ms},
                         {"census", ToJson(result.census)},
                         {"frame", result.frame},
                         {"error_m", result.error_m}};
  nlohmann::json& estimate = json["estimate"] = nlohmann::json::array();
  for (const Eigen::Vector2d& position : result.estimate) estimate.push_back({position.x(), position.y()});
  return json;
}

absl::StatusOr<VariantResult> ResultFromJson(const nlohmann::json& json) {
  try {
    VariantResult result;
    result.route = json.at("route");
    result.traffic_seed = json.at("traffic_seed");
    result.run = json.at("run");
    result.variant = json.at("variant");
    result.frames = json.at("frames");
    result.tracked = json.at("tracked");
    result.duration_s = json.at("duration_s");
    result.length_m = json.at("length_m");
    result.mape_percent = Optional(json.at("mape_percent"));
    result.ate_m = Optional(json.at("ate_m"));
    result.keyframes = json.at("keyframes");
    result.points = json.at("points");
    result.loops = json.at("loops");
    result.recoveries = json.at("recoveries");
    result.track_ms = json.at("track_ms");
    result.census = CensusFromJson(json.at("census"));
    result.frame = json.at("frame").get<std::vector<int>>();
    result.error_m = json.at("error_m").get<std::vector<double>>();
    for (const auto& position : json.at("estimate"))
      result.estimate.emplace_back(position.at(0), position.at(1));
    return result;
  } catch (const nlohmann::json::exception& error) {
    return absl::DataLossError(absl::StrCat("not a result: ", error.what()));
  }
}

}  // namespace semmap::bench
