#include "slam/pipeline/reprojection_error.h"

#include <cmath>

namespace semmap {

ReprojectionError MeasureReprojection(const Map& map, const ProjectionModel& model,
                                      const std::function<bool(const MapPoint&)>& admits) {
  ReprojectionError error;
  double squared = 0;
  for (const auto& [id, point] : map.points()) {
    if (!point.active || (admits && !admits(point))) continue;
    for (const Observation& observation : point.observations) {
      const KeyFrame& keyframe = *map.FindKeyFrame(observation.keyframe);
      const Eigen::Vector3d in_camera = keyframe.camera_from_map * point.position_in_map;
      if (in_camera.z() <= 0) continue;
      const Keypoint& keypoint = keyframe.features->keypoints[observation.keypoint];
      const double x = model.fx * in_camera.x() / in_camera.z() + model.cx;
      const double y = model.fy * in_camera.y() / in_camera.z() + model.cy;
      squared += (x - keypoint.x) * (x - keypoint.x) + (y - keypoint.y) * (y - keypoint.y);
      ++error.observations;
    }
  }
  if (error.observations > 0) error.rms_px = std::sqrt(squared / static_cast<double>(error.observations));
  return error;
}

}  // namespace semmap
