#pragma once

#include <random>
#include <vector>

#include "slam/geometry/se3.h"
#include "slam/optimize/bundle_adjustment.h"
#include "slam/optimize/observation.h"
#include "slam/optimize/pose_optimizer.h"

namespace semmap {

// KITTI-like camera.
inline ProjectionModel TestModel() {
  return {.fx = 718.9, .fy = 716.2, .cx = 607.2, .cy = 185.2, .focal_times_baseline = 386.1};
}

// What the pixel observation of a point in the camera frame is without noise.
inline PixelObservation Observe(const ProjectionModel& model, const Eigen::Vector3d& point_in_camera,
                                bool stereo) {
  PixelObservation pixel;
  pixel.u = model.fx * point_in_camera.x() / point_in_camera.z() + model.cx;
  pixel.v = model.fy * point_in_camera.y() / point_in_camera.z() + model.cy;
  // Kept from becoming negative, which would mean mono, by the scenes' depths and image positions.
  pixel.u_right = stereo ? pixel.u - model.focal_times_baseline / point_in_camera.z() : -1;
  return pixel;
}

inline void AddNoise(double sigma, std::mt19937& random, PixelObservation* pixel) {
  std::normal_distribution<double> noise(0, sigma);
  pixel->u += noise(random);
  pixel->v += noise(random);
  if (pixel->IsStereo()) pixel->u_right += noise(random);
}

// A point somewhere in view of a camera, 4 to 40 metres away.
inline Eigen::Vector3d PointInView(const ProjectionModel& model, std::mt19937& random) {
  std::uniform_real_distribution<double> u(150, 1200);
  std::uniform_real_distribution<double> v(10, 360);
  std::uniform_real_distribution<double> inverse_depth(1.0 / 40, 1.0 / 4);
  const double z = 1 / inverse_depth(random);
  return {(u(random) - model.cx) / model.fx * z, (v(random) - model.cy) / model.fy * z, z};
}

inline Vector6d RandomTangent(double translation, double rotation, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector6d tangent;
  for (int i = 0; i < 6; ++i) tangent(i) = normal(random) * (i < 3 ? translation : rotation);
  return tangent;
}

struct PoseScene {
  ProjectionModel model = TestModel();
  SE3 camera_from_map;
  std::vector<PoseObservation> observations;
};

struct PoseSceneOptions {
  int points = 300;
  double stereo_fraction = 0.5;
  double sigma_px = 1;
  double outlier_fraction = 0;
};

// One camera and its observations; the first outlier_fraction of them have a wrong place in the image.
inline PoseScene MakePoseScene(const PoseSceneOptions& options, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  PoseScene scene;
  scene.camera_from_map = SE3::Exp(RandomTangent(5, 0.8, random));
  const SE3 map_from_camera = scene.camera_from_map.Inverse();
  for (int i = 0; i < options.points; ++i) {
    const Eigen::Vector3d point = PointInView(scene.model, random);
    PoseObservation observation;
    observation.point_in_map = map_from_camera * point;
    observation.pixel = Observe(scene.model, point, uniform(random) < options.stereo_fraction);
    // Coarser pyramid levels see less exactly.
    const double sigma = options.sigma_px * std::pow(1.2, i % 8);
    observation.pixel.inverse_sigma2 = 1 / (sigma * sigma);
    AddNoise(sigma, random, &observation.pixel);
    if (i < options.outlier_fraction * options.points) observation.pixel.v += 30 + 100 * uniform(random);
    scene.observations.push_back(observation);
  }
  return scene;
}

}  // namespace semmap
