#include "slam/pipeline/point_fusion.h"

#include <optional>
#include <unordered_set>

#include "slam/pipeline/association.h"
#include "slam/pipeline/local_map_matcher.h"

namespace semmap {
namespace {

constexpr float kFusionRadius = 3;
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

bool WithinError(const Keypoint& keypoint, const Projection& projection, float inverse_sigma2) {
  const float dx = keypoint.x - projection.x;
  const float dy = keypoint.y - projection.y;
  float squared = dx * dx + dy * dy;
  if (keypoint.right_x < 0) return squared * inverse_sigma2 <= static_cast<float>(kChi2Mono);
  const float dr = keypoint.right_x - projection.right_x;
  squared += dr * dr;
  return squared * inverse_sigma2 <= static_cast<float>(kChi2Stereo);
}

int FindKeypoint(const Map& map, const KeyFrame& keyframe, const Projection& projection,
                 const MapPoint& point) {
  const WindowQuery query{projection.x,
                          projection.y,
                          kFusionRadius * map.scale_info().scales[projection.octave],
                          projection.octave - 1,
                          projection.octave + 1,
                          -1,
                          &point.descriptor};
  const WindowMatch match = FindInWindow({*keyframe.features, *keyframe.grid}, query, [&](int index) {
    const Keypoint& keypoint = keyframe.features->keypoints[index];
    return WithinError(keypoint, projection, map.scale_info().inverse_sigma2[keypoint.octave]);
  });
  return match.distance <= kStrictDistance ? match.keypoint : -1;
}

// Joins the point with what the keypoint sees now.
bool Join(MapPointId point_id, KeyFrameId keyframe_id, int keypoint, Map* map) {
  const MapPointId seen_id = map->FindKeyFrame(keyframe_id)->points[keypoint];
  if (!seen_id.IsValid()) {
    if (!map->AddObservation(point_id, keyframe_id, static_cast<uint32_t>(keypoint))) return false;
    map->UpdateAppearance(point_id);
    return true;
  }
  if (seen_id == point_id) return false;
  const bool seen_is_better =
      map->FindPoint(seen_id)->observations.size() > map->FindPoint(point_id)->observations.size();
  map->MergePoints(seen_is_better ? seen_id : point_id, seen_is_better ? point_id : seen_id);
  return true;
}

std::vector<MapPointId> PointsOf(const Map& map, KeyFrameId id) {
  std::vector<MapPointId> points;
  for (const MapPointId point : map.FindKeyFrame(id)->points) {
    if (point.IsValid()) points.push_back(point);
  }
  return points;
}

}  // namespace

int FusePoints(const MappingCamera& camera, const std::vector<MapPointId>& points, KeyFrameId keyframe_id,
               Map* map) {
  const KeyFrame& keyframe = *map->FindKeyFrame(keyframe_id);
  const Eigen::Vector3d center = keyframe.Center();
  int fused = 0;
  for (const MapPointId id : points) {
    const MapPoint* point = map->FindPoint(id);
    if (point == nullptr || SeenBy(*point, keyframe_id)) continue;
    const auto projection = Project(camera, *map, keyframe, center, *point);
    if (!projection) continue;
    const int keypoint = FindKeypoint(*map, keyframe, *projection, *point);
    if (keypoint >= 0 && Join(id, keyframe_id, keypoint, map)) ++fused;
  }
  return fused;
}

int FuseWithNeighbours(const MappingCamera& camera, KeyFrameId keyframe,
                       const std::vector<KeyFrameId>& neighbours, Map* map) {
  int fused = 0;
  for (const KeyFrameId neighbour : neighbours)
    fused += FusePoints(camera, PointsOf(*map, keyframe), neighbour, map);
  std::vector<MapPointId> theirs;
  std::unordered_set<MapPointId, IdHash> seen;
  for (const KeyFrameId neighbour : neighbours) {
    for (const MapPointId point : PointsOf(*map, neighbour)) {
      if (seen.insert(point).second) theirs.push_back(point);
    }
  }
  return fused + FusePoints(camera, theirs, keyframe, map);
}

}  // namespace semmap
