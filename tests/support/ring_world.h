#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "slam/map/map.h"
#include "slam/pipeline/mapping_camera.h"

namespace semmap::testing {

// Features of one view of the ring, with the world's point that each keypoint shows.
struct RingView {
  FrameFeatures features;
  std::vector<int> world_points;
};

// A ring road between two walls full of corners, without images: a view is the projection of the corners with
// a little noise in pixels and descriptors. Exact, fast, and shows one place twice when driven round. World
// frame: x right, y down, z forward at the start; the road's centre line is a circle of radius 20 m.
class RingWorld {
 public:
  explicit RingWorld(uint32_t seed, int points = 8000);

  // 640 x 480 pixels; stereo has a baseline of 0.5 m.
  static MappingCamera Camera(SensorType sensor);
  static ScalePyramidInfo ScaleInfo() { return {8, 1.2}; }
  // Where a vehicle is that has driven `angle` radians round the ring.
  static SE3 WorldFromCamera(double angle);

  // Noise depends on `noise_seed`. Depth and right_x are filled if the camera has depth.
  RingView View(const MappingCamera& camera, const SE3& world_from_camera, uint32_t noise_seed) const;
  const Eigen::Vector3d& corner(int index) const { return corners_[index].position; }

 private:
  struct Corner {
    Eigen::Vector3d position;
    Descriptor descriptor;
    float size = 1;  // metres at octave 0 seen from 1 m times the focal length
    float angle = 0;
  };
  std::vector<Corner> corners_;
};

// How the map of a drive round the ring goes wrong with each keyframe.
struct RingDrift {
  double turn = 0;       // radians about the vertical
  double scale_log = 0;  // growth of the unit, one camera only
};

// The map that a drive with drift makes: keyframe i (id i + 1) stands at angle (first + i) * step, and the
// first one is the map's frame. A corner that was out of sight for long becomes a new point, as it does for a
// mapper that does not recognize the place. `unit`: how many units of the map one metre is at first.
Map DriveRing(const RingWorld& world, const MappingCamera& camera, int keyframes, double step,
              const RingDrift& drift, int first = 0, double unit = 1);

// A keyframe of a view, without points.
KeyFrame MakeKeyFrame(const MappingCamera& camera, KeyFrameId id, const RingView& view,
                      const SE3& camera_from_map);

// Root mean square distance of the keyframes' centres from the truth, after alignment (similarity for one
// camera).
double RingError(const Map& map, double step, bool with_scale);

}  // namespace semmap::testing
