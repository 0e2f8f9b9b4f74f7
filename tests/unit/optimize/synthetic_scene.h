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

struct BundleSceneOptions {
  int fixed_cameras = 30;
  int free_cameras = 20;
  int points = 3000;
  int observations = 20000;
  double stereo_fraction = 0;
  double sigma_px = 1;
  double outlier_fraction = 0;
  // How far the initial values are off.
  double camera_error_m = 0.05;
  double camera_error_rad = 0.005;
  double point_error_m = 0.2;
};

struct BundleScene {
  BundleProblem truth;  // noisy observations, true cameras and points
  BundleProblem problem;
  std::vector<char> is_outlier;
};

// A drive along z, one camera a metre, fixed ones first; each point is seen by a run of consecutive cameras.
inline BundleScene MakeBundleScene(const BundleSceneOptions& options, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  BundleScene scene;
  BundleProblem& truth = scene.truth;
  truth.model = TestModel();
  const int cameras = options.fixed_cameras + options.free_cameras;
  for (int i = 0; i < cameras; ++i) {
    const SE3 map_from_camera = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.05 * i, 0, 0.8 * i)) *
                                SE3::Exp(RandomTangent(0.05, 0.02, random));
    truth.cameras.push_back({map_from_camera.Inverse(), i < options.fixed_cameras});
  }
  const int views = std::max(2, options.observations / options.points);
  for (int i = 0; i < options.points; ++i) {
    // Seen last by camera `newest`, at 4 to 40 m, and by those before it.
    const int newest =
        std::min(cameras - 1, views - 1 + static_cast<int>(uniform(random) * (cameras - views + 1)));
    truth.points.push_back(truth.cameras[newest].camera_from_map.Inverse() *
                           PointInView(truth.model, random));
    for (int camera = newest; camera > newest - views && camera >= 0; --camera) {
      BundleObservation observation;
      observation.camera = camera;
      observation.point = i;
      observation.pixel = Observe(truth.model, truth.cameras[camera].camera_from_map * truth.points.back(),
                                  uniform(random) < options.stereo_fraction);
      AddNoise(options.sigma_px, random, &observation.pixel);
      observation.pixel.inverse_sigma2 = 1 / (options.sigma_px * options.sigma_px);
      const bool outlier = uniform(random) < options.outlier_fraction;
      if (outlier) observation.pixel.v += 20 + 50 * uniform(random);
      scene.is_outlier.push_back(outlier);
      truth.observations.push_back(observation);
    }
  }
  scene.problem = truth;
  for (BundleCamera& camera : scene.problem.cameras) {
    const SE3 error = SE3::Exp(RandomTangent(options.camera_error_m, options.camera_error_rad, random));
    if (!camera.fixed) camera.camera_from_map = error * camera.camera_from_map;
  }
  for (Eigen::Vector3d& point : scene.problem.points) {
    point += RandomTangent(options.point_error_m, 0, random).head<3>();
  }
  return scene;
}

}  // namespace semmap
