#include "slam/pipeline/map_window.h"

#include <algorithm>

namespace semmap {
namespace {

// Inactive points that belong to the keyframe, relative to it.
void GatherPassengers(const Map& map, const KeyFrame& keyframe,
                      std::vector<std::pair<MapPointId, Eigen::Vector3d>>* in_camera) {
  for (const MapPointId id : keyframe.points) {
    const MapPoint* point = id.IsValid() ? map.FindPoint(id) : nullptr;
    if (point == nullptr || point->active || point->reference_keyframe != keyframe.id) continue;
    in_camera->emplace_back(id, keyframe.camera_from_map * point->position_in_map);
  }
}

}  // namespace

MapWindow MapWindow::Whole(const ProjectionModel& model, const Map& map) {
  std::vector<KeyFrameId> ids;
  for (const auto& [id, keyframe] : map.keyframes()) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  MapWindow window(model);
  for (const KeyFrameId id : ids) window.AddCamera(map, id, !map.FindKeyFrame(id)->parent.IsValid());
  for (const KeyFrameId id : ids) window.AddPointsOf(map, id);
  window.FixOne();
  window.AddObservations(map);
  return window;
}

void MapWindow::AddCamera(const Map& map, KeyFrameId id, bool fixed) {
  camera_index_.emplace(id, static_cast<int>(cameras_.size()));
  cameras_.push_back(id);
  problem_.cameras.push_back({map.FindKeyFrame(id)->camera_from_map, fixed});
}

void MapWindow::AddPointsOf(const Map& map, KeyFrameId id) {
  for (const MapPointId point : map.FindKeyFrame(id)->points) {
    const MapPoint* active = map.FindActivePoint(point);
    if (active == nullptr || !point_index_.emplace(point, static_cast<int>(points_.size())).second) continue;
    points_.push_back(point);
    problem_.points.push_back(active->position_in_map);
  }
}

void MapWindow::AddRim(const Map& map, size_t limit) {
  std::unordered_map<KeyFrameId, int, IdHash> seen;
  for (const MapPointId point : points_) {
    for (const Observation& observation : map.FindPoint(point)->observations) {
      if (!HasCamera(observation.keyframe)) ++seen[observation.keyframe];
    }
  }
  std::vector<std::pair<int, KeyFrameId>> ranked;
  for (const auto& [id, count] : seen) ranked.emplace_back(-count, id);
  std::sort(ranked.begin(), ranked.end());
  for (size_t i = 0; i < std::min(limit, ranked.size()); ++i) AddCamera(map, ranked[i].second, true);
}

void MapWindow::AddObservations(const Map& map) {
  for (size_t i = 0; i < points_.size(); ++i) {
    for (const Observation& observation : map.FindPoint(points_[i])->observations) {
      const auto camera = camera_index_.find(observation.keyframe);
      if (camera == camera_index_.end()) continue;
      const Keypoint& keypoint =
          map.FindKeyFrame(observation.keyframe)->features->keypoints[observation.keypoint];
      const double inverse_sigma2 = map.scale_info().inverse_sigma2[keypoint.octave];
      problem_.observations.push_back({camera->second,
                                       static_cast<int>(i),
                                       {keypoint.x, keypoint.y, keypoint.right_x, inverse_sigma2},
                                       false});
    }
  }
}

void MapWindow::FixOne() {
  const auto is_fixed = [](const BundleCamera& camera) { return camera.fixed; };
  if (std::any_of(problem_.cameras.begin(), problem_.cameras.end(), is_fixed)) return;
  const auto oldest = std::min_element(cameras_.begin(), cameras_.end());
  problem_.cameras[static_cast<size_t>(oldest - cameras_.begin())].fixed = true;
}

void MapWindow::WriteBack(Map* map) const {
  for (size_t i = 0; i < cameras_.size(); ++i) {
    const KeyFrame* keyframe = map->FindKeyFrame(cameras_[i]);
    if (problem_.cameras[i].fixed || keyframe == nullptr) continue;
    std::vector<std::pair<MapPointId, Eigen::Vector3d>> passengers;
    GatherPassengers(*map, *keyframe, &passengers);
    map->SetPose(cameras_[i], problem_.cameras[i].camera_from_map);
    const SE3 map_from_camera = problem_.cameras[i].camera_from_map.Inverse();
    for (const auto& [id, in_camera] : passengers) map->SetPosition(id, map_from_camera * in_camera);
  }
  for (size_t i = 0; i < points_.size(); ++i) {
    if (map->FindPoint(points_[i]) != nullptr) map->SetPosition(points_[i], problem_.points[i]);
  }
  for (const BundleObservation& observation : problem_.observations) {
    if (observation.outlier) map->RemoveObservation(points_[observation.point], cameras_[observation.camera]);
  }
  for (const MapPointId point : points_) map->UpdateViewing(point);
}

}  // namespace semmap
