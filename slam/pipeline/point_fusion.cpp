#include "slam/pipeline/point_fusion.h"

#include <optional>
#include <unordered_set>

#include "slam/pipeline/association.h"
#include "slam/pipeline/local_map_matcher.h"

namespace semmap {
namespace {

constexpr double kMinViewingCosine = 0.5;

bool SeenBy(const MapPoint& point, KeyFrameId keyframe) {
  for (const Observation& observation : point.observations) {
    if (observation.keyframe == keyframe) return true;
  }
  return false;
}

struct Projection {
  float x;
  float y;
  float right_x;
  int octave;
};

std::optional<Projection> Project(const MappingCamera& camera, const Map& map, const KeyFrame& keyframe,
                                  const Eigen::Vector3d& center, const MapPoint& point) {
  const Eigen::Vector3d in_camera = keyframe.camera_from_map * point.position_in_map;
  if (in_camera.z() <= 0) return std::nullopt;
  const Eigen::Vector2d pixel = ProjectPinhole(camera.rig.camera, in_camera);
  const auto x = static_cast<float>(pixel.x());
  const auto y = static_cast<float>(pixel.y());
  if (!camera.bounds.Contains(x, y)) return std::nullopt;
  const Eigen::Vector3d ray = point.position_in_map - center;
  const auto distance = static_cast<float>(ray.norm());
  if (distance < point.min_distance || distance > point.max_distance) return std::nullopt;
  if (ray.dot(point.normal.cast<double>()) < kMinViewingCosine * distance) return std::nullopt;
  const double shift = camera.model.focal_times_baseline / in_camera.z();
  return Projection{x, y, static_cast<float>(pixel.x() - shift),
                    PredictOctave(point.max_distance, distance, map.scale_info())};
}

bool WithinError(const Keypoint& keypoint, const Projection& projection, float weight) {
  const float dx = keypoint.x - projection.x;
  const float dy = keypoint.y - projection.y;
  float squared = dx * dx + dy * dy;
  if (keypoint.right_x < 0) return squared * weight <= static_cast<float>(kChi2Mono);
  const float dr = keypoint.right_x - projection.right_x;
  squared += dr * dr;
  return squared * weight <= static_cast<float>(kChi2Stereo);
}

// `admits(id)` tells whether a keypoint that sees this point (or none) may be the one.
template <typename Admits>
int FindKeypoint(const MappingCamera& camera, const Map& map, const KeyFrame& keyframe,
                 const Projection& projection, const FusionTolerance& tolerance, const MapPoint& point,
                 Admits&& admits) {
  const WindowQuery query{projection.x,
                          projection.y,
                          tolerance.radius * map.scale_info().scales[projection.octave],
                          projection.octave - 1,
                          projection.octave + 1,
                          -1,
                          &point.descriptor,
                          point.semantic_class};
  const float inverse_error_factor2 = 1 / (tolerance.error_factor * tolerance.error_factor);
  const auto available = [&](int index) {
    const Keypoint& keypoint = keyframe.features->keypoints[index];
    return admits(keyframe.points[index]) &&
           WithinError(keypoint, projection,
                       inverse_error_factor2 * map.scale_info().inverse_sigma2[keypoint.octave]);
  };
  const WindowMatch match =
      FindInWindow(camera.association, {*keyframe.features, *keyframe.grid}, query, available);
  return match.distance <= kStrictDistance ? match.keypoint : -1;
}

}  // namespace

bool JoinPoint(MapPointId point_id, KeyFrameId keyframe_id, int keypoint, Map* map) {
  const MapPointId seen_id = map->FindKeyFrame(keyframe_id)->points[keypoint];
  if (!seen_id.IsValid()) {
    if (!map->AddObservation(point_id, keyframe_id, static_cast<uint32_t>(keypoint))) return false;
    map->UpdateAppearance(point_id);
    return true;
  }
  if (seen_id == point_id) return false;
  if (map->FindActivePoint(seen_id) == nullptr) return false;
  const bool seen_is_better =
      map->FindPoint(seen_id)->observations.size() > map->FindPoint(point_id)->observations.size();
  map->MergePoints(seen_is_better ? seen_id : point_id, seen_is_better ? point_id : seen_id);
  return true;
}

std::vector<MapPointId> PointsSeenBy(const Map& map, const std::vector<KeyFrameId>& keyframes) {
  std::vector<MapPointId> points;
  std::unordered_set<MapPointId, IdHash> known;
  for (const KeyFrameId keyframe : keyframes) {
    for (const MapPointId point : map.FindKeyFrame(keyframe)->points) {
      if (map.FindActivePoint(point) != nullptr && known.insert(point).second) points.push_back(point);
    }
  }
  return points;
}

int FusePoints(const MappingCamera& camera, const std::vector<MapPointId>& points, KeyFrameId keyframe_id,
               const FusionTolerance& tolerance, Map* map) {
  const KeyFrame& keyframe = *map->FindKeyFrame(keyframe_id);
  const Eigen::Vector3d center = keyframe.Center();
  const auto admits = [&](MapPointId seen) {
    return !seen.IsValid() || map->FindActivePoint(seen) != nullptr;
  };
  int fused = 0;
  for (const MapPointId id : points) {
    const MapPoint* point = map->FindActivePoint(id);
    if (point == nullptr || SeenBy(*point, keyframe_id)) continue;
    const auto projection = Project(camera, *map, keyframe, center, *point);
    if (!projection) continue;
    const int keypoint = FindKeypoint(camera, *map, keyframe, *projection, tolerance, *point, admits);
    if (keypoint >= 0 && JoinPoint(id, keyframe_id, keypoint, map)) ++fused;
  }
  return fused;
}

int FuseWithNeighbours(const MappingCamera& camera, KeyFrameId keyframe,
                       const std::vector<KeyFrameId>& neighbours, Map* map) {
  int fused = 0;
  for (const KeyFrameId neighbour : neighbours)
    fused += FusePoints(camera, PointsSeenBy(*map, {keyframe}), neighbour, FusionTolerance(), map);
  return fused + FusePoints(camera, PointsSeenBy(*map, neighbours), keyframe, FusionTolerance(), map);
}

int ObserveInactivePoints(const MappingCamera& camera, KeyFrameId keyframe_id,
                          const std::vector<KeyFrameId>& neighbours, Map* map) {
  const KeyFrame& keyframe = *map->FindKeyFrame(keyframe_id);
  const Eigen::Vector3d center = keyframe.Center();
  const auto admits = [](MapPointId seen) { return !seen.IsValid(); };
  int observed = 0;
  for (const KeyFrameId neighbour : neighbours) {
    // The points of a keyframe do not change by being seen from another one.
    for (const MapPointId id : map->FindKeyFrame(neighbour)->points) {
      const MapPoint* point = id.IsValid() ? map->FindPoint(id) : nullptr;
      if (point == nullptr || point->active || SeenBy(*point, keyframe_id)) continue;
      const auto projection = Project(camera, *map, keyframe, center, *point);
      if (!projection) continue;
      const int keypoint =
          FindKeypoint(camera, *map, keyframe, *projection, FusionTolerance(), *point, admits);
      if (keypoint >= 0 && JoinPoint(id, keyframe_id, keypoint, map)) ++observed;
    }
  }
  return observed;
}

}  // namespace semmap
