#include "server/camera_comparison.h"

#include <cmath>

namespace semmap::server {
namespace {

bool IsNear(double a, double b) {
  constexpr double kMaxDifference = 1e-6;
  return std::abs(a - b) <= kMaxDifference;
}

}  // namespace

bool SameIntrinsics(const CameraRig& a, const CameraRig& b) {
  return a.camera.width == b.camera.width && a.camera.height == b.camera.height &&
         IsNear(a.camera.fx, b.camera.fx) && IsNear(a.camera.fy, b.camera.fy) &&
         IsNear(a.camera.cx, b.camera.cx) && IsNear(a.camera.cy, b.camera.cy);
}

bool SameCameras(const CameraRig& a, const CameraRig& b) {
  return a.sensor == b.sensor && IsNear(a.baseline_m, b.baseline_m) && SameIntrinsics(a, b);
}

}  // namespace semmap::server
