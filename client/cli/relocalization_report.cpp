#include "client/cli/relocalization_report.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "client/cli/table.h"

namespace semmap::client {
namespace {

// One standard deviation of the position: square root of the variances' sum.
double Deviation(const v1::PoseCovariance& covariance) {
  if (covariance.upper_triangle_size() != 21) return 0;
  return std::sqrt(covariance.upper_triangle(0) + covariance.upper_triangle(6) +
                   covariance.upper_triangle(11));
}

void AddGeographic(const nlohmann::json& answer, std::vector<std::string>* row) {
  const bool known = answer.contains("latitude_deg");
  for (const char* angle : {"latitude_deg", "longitude_deg"})
    row->push_back(known ? absl::StrFormat("%.8f", answer[angle].get<double>()) : "");
  row->push_back(known ? absl::StrFormat("%.3f", answer["altitude_m"].get<double>()) : "");
}

}  // namespace

std::string ResultName(v1::RelocalizeResult result) {
  return std::string(absl::StripPrefix(v1::RelocalizeResult_Name(result), "RELOCALIZE_RESULT_"));
}

nlohmann::json RelocalizationJson(const std::string& image, const v1::RelocalizeResponse& response) {
  nlohmann::json json;
  json["image"] = image;
  json["result"] = ResultName(response.result());
  json["inliers"] = response.inliers();
  json["matches"] = response.matches();
  json["map_version"] = response.map_version();
  json["processing_ms"] = response.processing_ms();
  if (response.has_map_from_camera()) {
    const v1::Vector3& t = response.map_from_camera().translation();
    const v1::Quaternion& q = response.map_from_camera().rotation();
    json["position"] = {t.x(), t.y(), t.z()};
    json["rotation"] = {q.x(), q.y(), q.z(), q.w()};
    json["deviation_m"] = Deviation(response.covariance());
    json["covariance"] = response.covariance().upper_triangle();
    json["keyframes"] = response.keyframe_ids();
  }
  if (response.has_geo_position()) {
    json["latitude_deg"] = response.geo_position().latitude_deg();
    json["longitude_deg"] = response.geo_position().longitude_deg();
    json["altitude_m"] = response.geo_position().altitude_m();
  }
  if (response.has_class_agreement()) json["class_agreement"] = response.class_agreement();
  return json;
}

std::string RelocalizationTable(const nlohmann::json& answers) {
  const bool geographic = std::any_of(answers.begin(), answers.end(), [](const nlohmann::json& answer) {
    return answer.contains("latitude_deg");
  });
  std::vector<std::string> heading = {"image",     "result",  "x",       "y",        "z",
                                      "deviation", "inliers", "matches", "keyframe", "ms"};
  if (geographic) heading.insert(heading.end(), {"latitude", "longitude", "altitude"});
  Table table(std::move(heading));
  for (const nlohmann::json& answer : answers) {
    std::vector<std::string> row = {answer["image"], answer["result"]};
    const bool found = answer.contains("position");
    for (size_t i = 0; i < 3; ++i)
      row.push_back(found ? absl::StrFormat("%.3f", answer["position"][i].get<double>()) : "");
    row.push_back(found ? absl::StrFormat("%.3f", answer["deviation_m"].get<double>()) : "");
    row.push_back(absl::StrFormat("%d", answer["inliers"].get<int>()));
    row.push_back(absl::StrFormat("%d", answer["matches"].get<int>()));
    const bool known = found && !answer["keyframes"].empty();
    row.push_back(known ? absl::StrFormat("%d", answer["keyframes"][0].get<uint64_t>()) : "");
    row.push_back(absl::StrFormat("%.1f", answer["processing_ms"].get<double>()));
    if (geographic) AddGeographic(answer, &row);
    table.AddRow(std::move(row));
  }
  return table.Format();
}

}  // namespace semmap::client
