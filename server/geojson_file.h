#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/geo_frame.h"
#include "server/output_file.h"
#include "slam/map/map_delta.h"

namespace semmap::server {

// Writes a map as GeoJSON (RFC 7946): a feature for each point with its class, and a line for each session
// with a pose. Holds one thing at a time. Not thread-safe.
class GeoJsonFile {
 public:
  // Both outlive this.
  GeoJsonFile(const GeoFrame* frame, OutputFile* output) : frame_(frame), output_(output) {}

  absl::Status AddPoint(const MapPointRecord& point);
  // The next place of this session's line; those of one session come one after the other.
  absl::Status AddPosition(const std::string& session, const std::string& vehicle,
                           const Eigen::Vector3d& position_in_map);
  // Last call.
  absl::Status Finish();

 private:
  absl::Status BeginFeature();
  absl::Status EndLine();
  std::string Coordinates(const Eigen::Vector3d& point_in_map) const;

  const GeoFrame* const frame_;
  OutputFile* const output_;
  std::string session_;        // whose line is being written; empty: none
  std::string last_position_;  // of the line
  int positions_ = 0;          // of the line
};

}  // namespace semmap::server
