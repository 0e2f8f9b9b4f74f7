#include "client/cli/relocalization_report.h"

#include <cmath>

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
  if (response.has_class_agreement()) json["class_agreement"] = response.class_agreement();
  return json;
}

std::string RelocalizationTable(const nlohmann::json& answers) {
  Table table({"image", "result", "x", "y", "z", "deviation", "inliers", "matches", "keyframe", "ms"});
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
    table.AddRow(std::move(row));
  }
  return table.Format();
}

}  // namespace semmap::client
