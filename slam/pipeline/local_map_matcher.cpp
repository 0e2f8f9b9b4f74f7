#include "slam/pipeline/local_map_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace semmap {
namespace {

constexpr float kMinViewingCosine = 0.5F;
// Seen almost from the mean direction, a point is predicted better.
constexpr float kFrontalCosine = 0.998F;
constexpr float kObliqueRadiusFactor = 1.6F;
// Corners are found somewhat outside of the levels they were seen at.
constexpr float kDistanceMargin = 1.2F;

struct Expected {
  WindowQuery window;
  double depth = 0;
  bool visible = false;
};

Expected Predict(const LocalMapView& view, size_t i, const SE3& camera_from_map,
                 const Eigen::Matrix3d& rotation, const Eigen::Vector3d& center,
                 const ProjectionSearch& search) {
  Expected expected;
  const Eigen::Vector3d point = rotation * view.positions[i] + camera_from_map.translation();
  if (point.z() <= 0) return expected;
  const double inverse_z = 1.0 / point.z();
  const auto x = static_cast<float>(search.model.fx * point.x() * inverse_z + search.model.cx);
  const auto y = static_cast<float>(search.model.fy * point.y() * inverse_z + search.model.cy);
  if (!search.bounds.Contains(x, y)) return expected;
  const Eigen::Vector3f ray = (view.positions[i] - center).cast<float>();
  const float distance = ray.norm();
  if (distance < view.min_distances[i] / kDistanceMargin ||
      distance > view.max_distances[i] * kDistanceMargin) {
    return expected;
  }
  const float cosine = ray.dot(view.normals[i]) / distance;
  if (cosine < kMinViewingCosine) return expected;
  const int octave = PredictOctave(view.max_distances[i], distance, *search.scale_info);
  const float radius = search.radius * (cosine > kFrontalCosine ? 1.0F : kObliqueRadiusFactor);
  const double right_x = x - search.model.focal_times_baseline * inverse_z;
  expected.visible = true;
  expected.depth = point.z();
  expected.window = {x,
                     y,
                     radius * search.scale_info->scales[octave],
                     octave - 1,
                     octave + 1,
                     search.model.focal_times_baseline > 0 ? static_cast<float>(right_x) : -1.0F,
                     &view.descriptors[i],
                     view.classes[i]};
  return expected;
}

double DepthOf(const LocalMapView& view, int32_t point, const SE3& camera_from_map) {
  return (camera_from_map * view.positions[point]).z();
}

}  // namespace

int PredictOctave(float max_distance, float distance, const ScalePyramidInfo& scale_info) {
  const float levels = std::log(max_distance / distance) / std::log(scale_info.scale_factor);
  return std::clamp(static_cast<int>(std::lround(levels)), 0, scale_info.levels() - 1);
}

Agreement MatchLocalMap(const LocalMapView& view, const SE3& camera_from_map, const SearchImage& image,
                        const ProjectionSearch& search, SightingCounters* counters, ViewMatches* matches) {
  std::vector<char> matched(view.size(), 0);
  for (const int32_t point : *matches) {
    if (point >= 0) matched[point] = 1;
  }
  const Eigen::Matrix3d rotation = camera_from_map.RotationMatrix();
  const Eigen::Vector3d center = camera_from_map.Inverse().translation();
  const auto is_free = [&](int keypoint) { return (*matches)[keypoint] < 0; };
  Agreement agreement;
  for (size_t i = 0; i < view.size(); ++i) {
    if (matched[i]) {
      ++counters->visible[i];
      ++agreement.expected;
      if (DepthOf(view, static_cast<int32_t>(i), camera_from_map) <= search.near_depth)
        ++agreement.near_expected;
      continue;
    }
    const Expected expected = Predict(view, i, camera_from_map, rotation, center, search);
    if (!expected.visible) continue;
    ++counters->visible[i];
    ++agreement.expected;
    if (expected.depth <= search.near_depth) ++agreement.near_expected;
    const WindowMatch best = FindInWindow(search.association, image, expected.window, is_free);
    if (best.keypoint < 0 || best.distance > kLooseDistance || !best.IsDistinct(search.distinct_ratio))
      continue;
    (*matches)[best.keypoint] = static_cast<int32_t>(i);
  }
  return agreement;
}

void CountInliers(const LocalMapView& view, const SE3& camera_from_map, double near_depth,
                  const ViewMatches& matches, Agreement* agreement) {
  for (const int32_t point : matches) {
    if (point < 0) continue;
    ++agreement->inliers;
    if (DepthOf(view, point, camera_from_map) <= near_depth) ++agreement->near_inliers;
  }
}

}  // namespace semmap
