#include "server/geojson_file.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/map_conversion.h"
#include "server/names.h"
#include "server/point_file.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

// Vehicles' names are any text.
std::string Quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      absl::StrAppend(&result, "\\", std::string(1, c));
    } else if (static_cast<unsigned char>(c) < 0x20) {
      absl::StrAppendFormat(&result, "\\u%04x", static_cast<unsigned>(c));
    } else {
      result.push_back(c);
    }
  }
  return result + "\"";
}

}  // namespace

// A billionth of a degree is a tenth of a millimetre.
std::string GeoJsonFile::Coordinates(const Eigen::Vector3d& point_in_map) const {
  const Eigen::Vector3d p = frame_->ToGeographic(point_in_map);
  return absl::StrFormat("[%.9f,%.9f,%.4f]", p.x(), p.y(), p.z());
}

absl::Status GeoJsonFile::BeginFeature() {
  return output_->Append(output_->size() == 0 ? "{\"type\":\"FeatureCollection\",\"features\":[\n" : ",\n");
}

absl::Status GeoJsonFile::AddPoint(const MapPointRecord& point) {
  SEMMAP_RETURN_IF_ERROR(BeginFeature());
  const auto rgb = ColourOf(point.semantic_class);
  return output_->Append(absl::StrFormat(
      "{\"type\":\"Feature\",\"geometry\":{\"type\":\"Point\",\"coordinates\":%s},\"properties\":{\"id\":%d,"
      "\"class\":%d,\"class_name\":\"%s\",\"confidence\":%.4g,\"observations\":%d,\"marker-color\":\"#%02x%"
      "02x%02x\"}}",
      Coordinates(point.position_in_map), point.id.value(), point.semantic_class,
      ClassName(point.semantic_class), point.class_confidence, point.observation_count, rgb[0], rgb[1],
      rgb[2]));
}

absl::Status GeoJsonFile::AddPosition(const std::string& session, const std::string& vehicle,
                                      const Eigen::Vector3d& position_in_map) {
  if (session != session_) {
    SEMMAP_RETURN_IF_ERROR(EndLine());
    SEMMAP_RETURN_IF_ERROR(BeginFeature());
    SEMMAP_RETURN_IF_ERROR(output_->Append(absl::StrCat(
        "{\"type\":\"Feature\",\"properties\":{\"session\":", Quoted(SessionName(session)),
        ",\"vehicle_id\":", Quoted(vehicle), "},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[")));
    session_ = session;
    positions_ = 0;
  }
  last_position_ = Coordinates(position_in_map);
  return output_->Append(absl::StrCat(positions_++ == 0 ? "" : ",", last_position_));
}

// A line has two positions at least.
absl::Status GeoJsonFile::EndLine() {
  if (session_.empty()) return absl::OkStatus();
  session_.clear();
  return output_->Append(absl::StrCat(positions_ == 1 ? "," + last_position_ : "", "]}}"));
}

absl::Status GeoJsonFile::Finish() {
  SEMMAP_RETURN_IF_ERROR(EndLine());
  if (output_->size() == 0) return output_->Append("{\"type\":\"FeatureCollection\",\"features\":[]}\n");
  return output_->Append("\n]}\n");
}

}  // namespace semmap::server
