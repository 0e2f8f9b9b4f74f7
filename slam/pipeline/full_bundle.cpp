#include "slam/pipeline/full_bundle.h"

#include <algorithm>
#include <vector>

namespace semmap {
namespace {

std::vector<KeyFrameId> SortedIds(const Map& map) {
  std::vector<KeyFrameId> ids;
  for (const auto& [id, keyframe] : map.keyframes()) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace

FullBundle::FullBundle(const LoopConfig& config, const ProjectionModel& model, const Map& map)
    : config_(config), window_(MapWindow::Whole(model, map)) {}

BundleSummary FullBundle::Solve(const std::atomic<bool>* stop) {
  BundleOptions options;
  options.first_iterations = config_.full_iterations / 2;
  options.second_iterations = config_.full_iterations - options.first_iterations;
  options.stop = stop;
  return window_.Solve(options);
}

void FullBundle::Apply(Map* map) const {
  std::unordered_map<KeyFrameId, SE3, IdHash> before;
  for (const auto& [id, keyframe] : map->keyframes()) before.emplace(id, keyframe.camera_from_map);
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> newer_points;  // in the reference keyframe
  for (const auto& [id, point] : map->points()) {
    if (window_.HasPoint(id)) continue;
    newer_points.emplace_back(id, before.at(point.reference_keyframe) * point.position_in_map);
  }
  window_.WriteBack(map);
  // Ids grow with time and a parent is older than its children: one pass follows the whole tree.
  for (const KeyFrameId id : SortedIds(*map)) {
    const KeyFrame& keyframe = *map->FindKeyFrame(id);
    if (window_.HasCamera(id) || !keyframe.parent.IsValid()) continue;
    const SE3 camera_from_parent = before.at(id) * before.at(keyframe.parent).Inverse();
    map->SetPose(id, camera_from_parent * map->FindKeyFrame(keyframe.parent)->camera_from_map);
  }
  for (const auto& [id, point_in_reference] : newer_points) {
    const MapPoint* point = map->FindPoint(id);
    if (point == nullptr) continue;
    const KeyFrame& reference = *map->FindKeyFrame(point->reference_keyframe);
    map->SetPosition(id, reference.camera_from_map.Inverse() * point_in_reference);
    map->UpdateViewing(id);
  }
}

}  // namespace semmap
