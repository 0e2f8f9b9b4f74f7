#include "tests/support/ring_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slam/geometry/alignment.h"

namespace semmap::testing {
namespace {

constexpr double kRadius = 20;
constexpr double kHalfWidth = 5;
constexpr double kFocalLength = 400;
constexpr double kBaseline = 0.5;
constexpr double kPixelNoise = 0.3;
constexpr int kFlippedBits = 6;
constexpr double kFarthest = 40;
// After so many keyframes out of sight a corner counts as new.
constexpr int kMemory = 4;

Descriptor RandomDescriptor(std::mt19937_64& random) {
  Descriptor descriptor;
  for (uint64_t& word : descriptor.words) word = random();
  return descriptor;
}

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
}

// The vehicle's relative motion from one keyframe to the next, spoilt.
SE3 Spoil(const SE3& motion, const RingDrift& drift, double unit) {
  const SE3 turn(ExpSO3({0, drift.turn, 0}), Eigen::Vector3d::Zero());
  return SE3(motion.rotation(), unit * motion.translation()) * turn;
}

}  // namespace

RingWorld::RingWorld(uint32_t seed, int points) {
  std::mt19937_64 random(seed);
  for (int i = 0; i < points; ++i) {
    Corner corner;
    const double angle = Uniform(random, 0, 2 * std::numbers::pi);
    const double radius =
        kRadius + (random() % 2 == 0 ? 1 : -1) * Uniform(random, kHalfWidth, kHalfWidth + 1);
    corner.position = {radius * std::cos(angle) - kRadius, Uniform(random, -4, 2), radius * std::sin(angle)};
    corner.descriptor = RandomDescriptor(random);
    corner.size = static_cast<float>(Uniform(random, 12, 40));
    corner.angle = static_cast<float>(Uniform(random, 0, 6));
    corners_.push_back(corner);
  }
}

MappingCamera RingWorld::Camera(SensorType sensor) {
  MappingCamera camera;
  camera.rig.sensor = sensor;
  camera.rig.camera.width = 640;
  camera.rig.camera.height = 480;
  camera.rig.camera.fx = camera.rig.camera.fy = kFocalLength;
  camera.rig.camera.cx = 320;
  camera.rig.camera.cy = 240;
  camera.rig.baseline_m = sensor == SensorType::kMono ? 0 : kBaseline;
  camera.bounds = UndistortedBounds(camera.rig.camera);
  camera.model = {kFocalLength, kFocalLength, 320, 240, kFocalLength * camera.rig.baseline_m};
  return camera;
}

SE3 RingWorld::WorldFromCamera(double angle) {
  // Centre of the ring at x = -radius; driving along +z at angle 0, turning left.
  const Eigen::Vector3d position(kRadius * std::cos(angle) - kRadius, 0, kRadius * std::sin(angle));
  return {ExpSO3({0, -angle, 0}), position};
}

RingView RingWorld::View(const MappingCamera& camera, const SE3& world_from_camera,
                         uint32_t noise_seed) const {
  std::mt19937_64 random(noise_seed);
  const SE3 camera_from_world = world_from_camera.Inverse();
  const ScalePyramidInfo scales = ScaleInfo();
  RingView view;
  for (size_t i = 0; i < corners_.size(); ++i) {
    const Corner& corner = corners_[i];
    const Eigen::Vector3d point = camera_from_world * corner.position;
    if (point.z() < 1 || point.norm() > kFarthest) continue;
    const auto octave =
        static_cast<int>(std::lround(std::log(corner.size / point.norm()) / std::log(scales.scale_factor)));
    if (octave < 0 || octave >= scales.levels()) continue;
    const Eigen::Vector2d pixel = ProjectPinhole(camera.rig.camera, point);
    Keypoint keypoint;
    const double noise = kPixelNoise * scales.scales[octave];
    keypoint.x = static_cast<float>(pixel.x() + Uniform(random, -noise, noise));
    keypoint.y = static_cast<float>(pixel.y() + Uniform(random, -noise, noise));
    if (!camera.bounds.Contains(keypoint.x, keypoint.y)) continue;
    keypoint.octave = static_cast<uint8_t>(octave);
    keypoint.angle = corner.angle;
    if (camera.HasDepth()) {
      keypoint.depth = static_cast<float>(point.z());
      keypoint.right_x = static_cast<float>(keypoint.x - camera.model.focal_times_baseline / point.z());
    }
    Descriptor descriptor = corner.descriptor;
    for (int flip = 0; flip < kFlippedBits; ++flip) {
      const uint64_t bit = random() % 256;
      descriptor.words[bit / 64] ^= uint64_t{1} << (bit % 64);
    }
    view.features.keypoints.push_back(keypoint);
    view.features.descriptors.push_back(descriptor);
    view.world_points.push_back(static_cast<int>(i));
  }
  return view;
}

KeyFrame MakeKeyFrame(const MappingCamera& camera, KeyFrameId id, const RingView& view,
                      const SE3& camera_from_map) {
  KeyFrame keyframe;
  keyframe.id = id;
  keyframe.sequence = id.value();
  keyframe.timestamp = FromSeconds(0.1 * static_cast<double>(id.value()));
  keyframe.camera_from_map = camera_from_map;
  keyframe.features = std::make_shared<FrameFeatures>(view.features);
  keyframe.grid = std::make_shared<FeatureGrid>(camera.bounds, view.features.keypoints);
  keyframe.points.assign(view.features.size(), MapPointId());
  return keyframe;
}

Map DriveRing(const RingWorld& world, const MappingCamera& camera, int keyframes, double step,
              const RingDrift& drift, int first, double unit) {
  Map map(RingWorld::ScaleInfo());
  struct Known {
    MapPointId point;
    int last_seen = 0;
  };
  std::unordered_map<int, Known> known;
  SE3 map_from_camera;
  for (int i = 0; i < keyframes; ++i) {
    const SE3 world_from_camera = RingWorld::WorldFromCamera((first + i) * step);
    if (i > 0) {
      const SE3 motion = RingWorld::WorldFromCamera((first + i - 1) * step).Inverse() * world_from_camera;
      map_from_camera = map_from_camera * Spoil(motion, drift, unit);
      unit *= std::exp(drift.scale_log);
    }
    const KeyFrameId id(static_cast<uint64_t>(i + 1));
    const RingView view = world.View(camera, world_from_camera, static_cast<uint32_t>(1000 * first + i + 1));
    map.AddKeyFrame(MakeKeyFrame(camera, id, view, map_from_camera.Inverse()));
    for (size_t k = 0; k < view.world_points.size(); ++k) {
      Known& corner = known[view.world_points[k]];
      if (!corner.point.IsValid() || i - corner.last_seen > kMemory) {
        const Keypoint& keypoint = view.features.keypoints[k];
        // Depth as a mapper would have found it: the truth in the unit of the place.
        const Eigen::Vector3d in_camera = world_from_camera.Inverse() * world.corner(view.world_points[k]);
        const Eigen::Vector3d ray = RayOfPixel(camera.rig.camera, {keypoint.x, keypoint.y});
        corner.point = map.AddPoint(map_from_camera * (unit * in_camera.z() * ray), id);
      }
      corner.last_seen = i;
      map.AddObservation(corner.point, id, static_cast<uint32_t>(k));
    }
    map.ChooseParent(id);
  }
  std::vector<MapPointId> points;
  for (const auto& [id, point] : map.points()) points.push_back(id);
  for (const MapPointId id : points) map.UpdateAppearance(id);
  return map;
}

double RingError(const Map& map, double step, bool with_scale) {
  std::vector<Eigen::Vector3d> truth;
  std::vector<Eigen::Vector3d> estimate;
  for (const auto& [id, keyframe] : map.keyframes()) {
    truth.push_back(RingWorld::WorldFromCamera(static_cast<double>(id.value() - 1) * step).translation());
    estimate.push_back(keyframe.Center());
  }
  const auto truth_from_map = AlignPoints(estimate, truth, with_scale);
  if (!truth_from_map.ok()) return 1e9;
  double squared = 0;
  for (size_t i = 0; i < truth.size(); ++i)
    squared += (*truth_from_map * estimate[i] - truth[i]).squaredNorm();
  return std::sqrt(squared / static_cast<double>(truth.size()));
}

}  // namespace semmap::testing
