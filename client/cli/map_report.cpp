#include "client/cli/map_report.h"

#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/class_names.h"
#include "client/cli/table.h"
#include "client/names.h"

namespace semmap::client {
namespace {

using Json = nlohmann::json;

Json VectorJson(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

Json BoxJson(bool there, const v1::Box& box) {
  if (!there) return nullptr;
  return {{"min", VectorJson(box.min())}, {"max", VectorJson(box.max())}};
}

std::string BoxText(bool there, const v1::Box& box) {
  if (!there) return "-";
  return absl::StrFormat("x %.1f to %.1f, y %.1f to %.1f, z %.1f to %.1f m", box.min().x(), box.max().x(),
                         box.min().y(), box.max().y(), box.min().z(), box.max().z());
}

Json AnchorJson(const v1::GeoAnchor& anchor) {
  const v1::Similarity& enu_from_map = anchor.enu_from_map();
  const v1::Quaternion& q = enu_from_map.pose().rotation();
  return {{"latitude_deg", anchor.origin().latitude_deg()},
          {"longitude_deg", anchor.origin().longitude_deg()},
          {"altitude_m", anchor.origin().altitude_m()},
          {"source", anchor.source() == v1::GeoAnchor::SOURCE_GNSS ? "gnss" : "manual"},
          {"rms_error_m", anchor.rms_error_m()},
          {"enu_from_map",
           {{"scale", enu_from_map.scale()},
            {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}},
            {"translation", VectorJson(enu_from_map.pose().translation())}}}};
}

// The lines that only some maps have.
std::string DescriptionText(const v1::Map& map) {
  std::string text;
  if (!map.display_name().empty()) absl::StrAppend(&text, "called      ", map.display_name(), "\n");
  const std::map<std::string, std::string> labels(map.labels().begin(), map.labels().end());
  for (const auto& [key, value] : labels) absl::StrAppend(&text, "label       ", key, " = ", value, "\n");
  if (!map.has_anchor()) return text;
  const v1::GeoAnchor& anchor = map.anchor();
  absl::StrAppendFormat(&text, "anchor      %.7f, %.7f, %.1f m, %s\n", anchor.origin().latitude_deg(),
                        anchor.origin().longitude_deg(), anchor.origin().altitude_m(),
                        anchor.source() == v1::GeoAnchor::SOURCE_GNSS
                            ? absl::StrFormat("fitted to satellite fixes, %.2f m RMS", anchor.rms_error_m())
                            : "given");
  return text;
}

}  // namespace

const char* MapStateName(v1::MapState state) {
  switch (state) {
    case v1::MAP_STATE_EMPTY:
      return "empty";
    case v1::MAP_STATE_READY:
      return "ready";
    default:
      return "unknown";
  }
}

Json MapJson(const v1::Map& map) {
  Json labels = Json::object();
  for (const auto& [key, value] : map.labels()) labels[key] = value;
  return {{"name", IdOfName(map.name())},
          {"display_name", map.display_name()},
          {"labels", labels},
          {"anchor", map.has_anchor() ? AnchorJson(map.anchor()) : Json()},
          {"state", MapStateName(map.state())},
          {"version", map.version()},
          {"keyframes", map.keyframe_count()},
          {"points", map.point_count()},
          {"create_time", map.create_time().seconds()},
          {"update_time", map.update_time().seconds()}};
}

Json MapSummaryJson(const v1::MapSummary& summary) {
  Json result = MapJson(summary.map());
  result["point_extent"] = BoxJson(summary.has_point_extent(), summary.point_extent());
  result["keyframe_extent"] = BoxJson(summary.has_keyframe_extent(), summary.keyframe_extent());
  result["trajectory_length_m"] = summary.trajectory_length_m();
  result["frames"] = summary.frame_count();
  result["sessions"] = summary.session_count();
  result["size_bytes"] = summary.size_bytes();
  result["first_timestamp_ns"] = summary.first_timestamp_ns();
  result["last_timestamp_ns"] = summary.last_timestamp_ns();
  result["classes"] = Json::array();
  for (const v1::ClassCount& count : summary.classes()) {
    result["classes"].push_back({{"class", count.semantic_class()},
                                 {"name", ClassName(count.semantic_class())},
                                 {"points", count.points()}});
  }
  return result;
}

std::string MapSummaryTable(const v1::MapSummary& summary) {
  const v1::Map& map = summary.map();
  std::string text = absl::StrFormat(
      "name        %s\n"
      "state       %s, version %d\n"
      "updated     %s UTC\n"
      "holds       %d keyframes, %d points, %d sessions, %d frames\n"
      "length      %.1f m\n"
      "points in   %s\n"
      "cameras in  %s\n"
      "size        %s\n",
      IdOfName(map.name()), MapStateName(map.state()), map.version(), FormatUtc(map.update_time().seconds()),
      map.keyframe_count(), map.point_count(), summary.session_count(), summary.frame_count(),
      summary.trajectory_length_m(), BoxText(summary.has_point_extent(), summary.point_extent()),
      BoxText(summary.has_keyframe_extent(), summary.keyframe_extent()), FormatBytes(summary.size_bytes()));
  absl::StrAppend(&text, DescriptionText(map));
  if (summary.classes().empty()) return text;
  Table classes({"CLASS", "NAME", "POINTS"});
  for (const v1::ClassCount& count : summary.classes()) {
    classes.AddRow({absl::StrCat(count.semantic_class()), ClassName(count.semantic_class()),
                    absl::StrCat(count.points())});
  }
  return absl::StrCat(text, "\n", classes.Format());
}

Json MapCheckJson(const v1::CheckMapResponse& response) {
  Json result = {{"sound", response.problems().empty()},
                 {"keyframes", response.keyframes()},
                 {"points", response.points()},
                 {"observations", response.observations()},
                 {"problems", Json::array()}};
  for (const v1::MapProblem& problem : response.problems()) {
    result["problems"].push_back(
        {{"check", problem.check()}, {"count", problem.count()}, {"detail", problem.detail()}});
  }
  return result;
}

std::string MapCheckTable(const v1::CheckMapResponse& response) {
  std::string text = absl::StrFormat("looked at %d keyframes, %d points, %d observations\n",
                                     response.keyframes(), response.points(), response.observations());
  if (response.problems().empty()) return absl::StrCat(text, "sound\n");
  Table problems({"PROBLEM", "COUNT", "EXAMPLE"});
  for (const v1::MapProblem& problem : response.problems()) {
    problems.AddRow({problem.check(), absl::StrCat(problem.count()), problem.detail()});
  }
  return absl::StrCat(text, problems.Format());
}

}  // namespace semmap::client
