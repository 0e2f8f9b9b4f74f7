#pragma once

#include <GeographicLib/LocalCartesian.hpp>

#include <Eigen/Core>

#include "storage/map_store.h"

namespace semmap::server {

// Takes points of an anchored map to WGS84 and back, over the ellipsoid (GeographicLib).
class GeoFrame {
 public:
  explicit GeoFrame(const storage::GeoAnchor& anchor);

  // Longitude and latitude in degrees, altitude in metres above the ellipsoid: x, y and z of
  // COORDINATES_WGS84.
  Eigen::Vector3d ToGeographic(const Eigen::Vector3d& point_in_map) const;
  Eigen::Vector3d ToMap(const Eigen::Vector3d& longitude_latitude_altitude) const;

  // What is up at the anchor's origin, of unit length, in the frame of the map.
  Eigen::Vector3d UpInMap() const;
  double metres_per_unit() const { return enu_from_map_.scale; }

 private:
  GeographicLib::LocalCartesian enu_;
  Sim3 enu_from_map_;
};

}  // namespace semmap::server
