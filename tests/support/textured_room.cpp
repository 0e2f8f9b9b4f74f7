#include "tests/support/textured_room.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace semmap::testing {
namespace {

// Half width, half height and length of the room, metres.
constexpr double kHalfWidth = 4.0;
constexpr double kHalfHeight = 2.5;
constexpr double kBack = -5.0;
constexpr double kFront = 40.0;

double Hash(uint32_t seed, int wall, int x, int y) {
  uint32_t h = seed * 0x9E3779B1U ^ static_cast<uint32_t>(wall) * 0x85EBCA77U ^
               static_cast<uint32_t>(x) * 0xC2B2AE3DU ^ static_cast<uint32_t>(y) * 0x27D4EB2FU;
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 12;
  h *= 0x297A2D39U;
  h ^= h >> 15;
  return h / static_cast<double>(std::numeric_limits<uint32_t>::max());
}

struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  int wall = -1;
};

// Intersects the ray with the planes axis = low and axis = high.
void Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray, int axis, double low, double high,
               Hit* hit) {
  if (std::abs(ray[axis]) < 1e-12) return;
  const double plane = ray[axis] > 0 ? high : low;
  const double distance = (plane - origin[axis]) / ray[axis];
  if (distance > 0 && distance < hit->distance) *hit = {distance, 2 * axis + (ray[axis] > 0 ? 1 : 0)};
}

}  // namespace

double TexturedRoom::Noise(int wall, double u, double v) const {
  const int x = static_cast<int>(std::floor(u));
  const int y = static_cast<int>(std::floor(v));
  const double fx = u - x;
  const double fy = v - y;
  const double top = Hash(seed_, wall, x, y) * (1 - fx) + Hash(seed_, wall, x + 1, y) * fx;
  const double bottom = Hash(seed_, wall, x, y + 1) * (1 - fx) + Hash(seed_, wall, x + 1, y + 1) * fx;
  return top * (1 - fy) + bottom * fy;
}

double TexturedRoom::Texture(int wall, double u, double v) const {
  // Coarse blobs for far walls, hard-edged tiles for corners, fine grain for near ones.
  const double blobs = Noise(wall, 1.5 * u, 1.5 * v);
  const double tile =
      Hash(seed_ + 7, wall, static_cast<int>(std::floor(3 * u)), static_cast<int>(std::floor(3 * v)));
  const double grain = Noise(wall + 16, 12 * u, 12 * v);
  return 40 + 60 * blobs + 90 * tile + 40 * grain;
}

cv::Mat TexturedRoom::Render(const CameraIntrinsics& camera, const SE3& map_from_camera,
                             cv::Mat* depth) const {
  cv::Mat image(camera.height, camera.width, CV_8UC1);
  if (depth != nullptr) depth->create(camera.height, camera.width, CV_32FC1);
  const Eigen::Matrix3d rotation = map_from_camera.RotationMatrix();
  const Eigen::Vector3d& origin = map_from_camera.translation();
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const Eigen::Vector3d ray = rotation * RayOfPixel(camera, Eigen::Vector2d(column, row));
      Hit hit;
      Intersect(origin, ray, 0, -kHalfWidth, kHalfWidth, &hit);
      Intersect(origin, ray, 1, -kHalfHeight, kHalfHeight, &hit);
      Intersect(origin, ray, 2, kBack, kFront, &hit);
      const Eigen::Vector3d point = origin + hit.distance * ray;
      const int axis = hit.wall / 2;
      const double value = Texture(hit.wall, point[(axis + 1) % 3], point[(axis + 2) % 3]);
      image.at<uint8_t>(row, column) = static_cast<uint8_t>(std::lround(value));
      // The ray has z = 1 in the camera, so its parameter is the depth.
      if (depth != nullptr) depth->at<float>(row, column) = static_cast<float>(hit.distance);
    }
  }
  return image;
}

CameraIntrinsics SmallCamera() {
  CameraIntrinsics camera;
  camera.width = 480;
  camera.height = 320;
  camera.fx = camera.fy = 300;
  camera.cx = 239.5;
  camera.cy = 159.5;
  return camera;
}

CameraRig SmallRig(SensorType sensor) {
  CameraRig rig;
  rig.sensor = sensor;
  rig.camera = SmallCamera();
  rig.baseline_m = sensor == SensorType::kStereo ? 0.3 : 0.0;
  rig.depth_units_per_metre = 1000;
  rig.frames_per_second = 10;
  return rig;
}

std::vector<SE3> GentleDrive(int count, double step) {
  std::vector<SE3> poses;
  for (int i = 0; i < count; ++i) {
    const double z = i * step;
    const double x = 0.8 * std::sin(0.35 * z);
    const double heading = std::atan(0.8 * 0.35 * std::cos(0.35 * z));
    poses.emplace_back(Eigen::Quaterniond(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitY())),
                       Eigen::Vector3d(x, 0.0, z));
  }
  return poses;
}

SE3 LookAround(double degrees) {
  const Eigen::Quaterniond turn = ExpSO3({0, degrees * std::numbers::pi / 180, 0});
  const Eigen::Vector3d center(0.2, 0, 0.5);
  return {turn, center + turn * Eigen::Vector3d(0, 0, 0.4)};
}

}  // namespace semmap::testing
