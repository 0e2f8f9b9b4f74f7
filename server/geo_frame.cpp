#include "server/geo_frame.h"

namespace semmap::server {

GeoFrame::GeoFrame(const storage::GeoAnchor& anchor)
    : enu_(anchor.latitude_deg, anchor.longitude_deg, anchor.altitude_m),
      enu_from_map_(anchor.enu_from_map) {}

Eigen::Vector3d GeoFrame::ToGeographic(const Eigen::Vector3d& point_in_map) const {
  const Eigen::Vector3d enu = enu_from_map_ * point_in_map;
  Eigen::Vector3d result;
  enu_.Reverse(enu.x(), enu.y(), enu.z(), result.y(), result.x(), result.z());
  return result;
}

Eigen::Vector3d GeoFrame::ToMap(const Eigen::Vector3d& longitude_latitude_altitude) const {
  Eigen::Vector3d enu;
  const Eigen::Vector3d& p = longitude_latitude_altitude;
  enu_.Forward(p.y(), p.x(), p.z(), enu.x(), enu.y(), enu.z());
  return enu_from_map_.Inverse() * enu;
}

Eigen::Vector3d GeoFrame::UpInMap() const {
  return enu_from_map_.rigid.rotation().conjugate() * Eigen::Vector3d::UnitZ();
}

}  // namespace semmap::server
