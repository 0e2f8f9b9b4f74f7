#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

namespace semmap::client {

// How a scene in the ground frame lands on a part of a picture. Either view fits a box into it.
class MapProjection {
 public:
  // From above, y upwards on the picture.
  static MapProjection Top(const Eigen::AlignedBox3d& box, const cv::Rect& area);
  // From beyond the box's long side, obliquely from above.
  static MapProjection Perspective(const Eigen::AlignedBox3d& box, const cv::Rect& area);

  struct Pixel {
    cv::Point2d at;
    // Pixels for each metre where the point is.
    double scale = 0;
    // Grows towards who looks: what is greater hides what is less.
    double nearness = 0;
  };
  // Nothing for points behind who looks.
  std::optional<Pixel> Project(const Eigen::Vector3d& point) const;

 private:
  bool perspective_ = false;
  Eigen::Isometry3d view_from_ground_ = Eigen::Isometry3d::Identity();  // x right, y down, z away
  double focal_ = 1;                                                    // pixels; of Top: pixels a metre
  cv::Point2d centre_;
};

}  // namespace semmap::client
