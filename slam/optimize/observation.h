#pragma once

#include <Eigen/Core>

namespace semmap {

// A pinhole camera with an optional second eye, as the optimizer sees it: undistorted pixels.
struct ProjectionModel {
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  // fx * baseline in pixel metres; u_right = u - focal_times_baseline / z.
  double focal_times_baseline = 0;
};

// Where a point was seen. u_right is negative when only one eye saw it.
struct PixelObservation {
  double u = 0;
  double v = 0;
  double u_right = -1;
  // 1 / sigma^2 of the pixel coordinates, 1 / px^2.
  double inverse_sigma2 = 1;

  bool IsStereo() const { return u_right >= 0; }
};

// 95 % quantiles of chi^2 for two and three degrees of freedom: the bounds between inlier and outlier.
constexpr double kChi2Mono = 5.991;
constexpr double kChi2Stereo = 7.815;

// Points nearer to the camera's plane than this, in metres, or behind it have no projection; such an observation
// counts as one that is a hundred sigma off.
constexpr double kMinDepth = 1e-6;
constexpr double kChi2Behind = 1e4;

inline double Chi2Bound(const PixelObservation& observation) {
  return observation.IsStereo() ? kChi2Stereo : kChi2Mono;
}

}  // namespace semmap
