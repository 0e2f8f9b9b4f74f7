#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/client.h"
#include "slam/geometry/se3.h"

namespace semmap::bench {

// Where a map's frames truly were.
class MapTruth {
 public:
  // `truth`: poses of the recording that became `map`, in a frame that queries share (KITTI's format),
  // `times` its times.txt. A map of one camera needs `with_scale`.
  static absl::StatusOr<MapTruth> Read(client::Client& client, const std::string& map,
                                       const std::string& times, const std::string& truth, bool with_scale);

  // By one similarity for all of the map, fitted to the positions of its keyframes.
  SE3 ToWorld(const SE3& map_from_camera) const;
  // By one fitted to the frames of the map that were taken nearest to `world_near`: what is left of the error
  // is of finding oneself in the map, not of how the map is bent.
  SE3 ToWorldNear(const SE3& map_from_camera, const Eigen::Vector3d& world_near) const;

  // Distance of the nearest keyframe, metres.
  double Distance(const SE3& world_from_camera) const;
  // Whether one stood so near that it shows what the camera sees and, if headings count, looked about the
  // same way.
  bool Shows(const SE3& world_from_camera, bool any_heading) const;

 private:
  struct Frame {
    SE3 world_from_camera;
    SE3 map_from_camera;
  };

  bool with_scale_ = false;
  Sim3 world_from_map_;
  std::vector<SE3> world_from_keyframe_;
  std::vector<Frame> frames_;
};

}  // namespace semmap::bench
