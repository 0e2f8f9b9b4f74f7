#include "slam/pipeline/essential_graph.h"

#include <algorithm>
#include <set>
#include <utility>

namespace semmap {
namespace {

// Relative poses along the drive are good to these shares of the distance, radians and shares of the scale.
constexpr double kDriveTranslation = 0.01;
constexpr double kDriveRotation = 0.001;
constexpr double kDriveScale = 0.01;

}  // namespace

EssentialGraph::EssentialGraph(int min_shared, bool with_scale, const Map& map) {
  graph_.with_scale = with_scale;
  for (const auto& [id, keyframe] : map.keyframes()) ids_.push_back(id);
  std::sort(ids_.begin(), ids_.end());
  for (const KeyFrameId id : ids_) {
    const KeyFrame& keyframe = *map.FindKeyFrame(id);
    index_.emplace(id, static_cast<int>(graph_.nodes.size()));
    graph_.nodes.push_back({{1.0, keyframe.camera_from_map.Inverse()}, !keyframe.parent.IsValid()});
  }
  for (const KeyFrameId id : ids_) AddEdgesOf(*map.FindKeyFrame(id), min_shared);
  typical_distance_ = TypicalDistance();
  for (PoseGraphEdge& edge : graph_.edges) Weigh(1.0, &edge);
}

void EssentialGraph::AddLoop(const Loop& loop, double precision) {
  PoseGraphEdge edge{index_.at(loop.old), index_.at(loop.current), loop.old_from_current};
  Weigh(precision, &edge);
  graph_.edges.push_back(edge);
}

void EssentialGraph::AddEdgesOf(const KeyFrame& keyframe, int min_shared) {
  std::set<KeyFrameId> tied(keyframe.loops.begin(), keyframe.loops.end());
  for (const auto& [other, shared] : keyframe.covisible) {
    if (shared >= min_shared) tied.insert(other);
  }
  std::erase_if(tied, [&](KeyFrameId other) { return other > keyframe.id; });  // each pair once
  if (keyframe.parent.IsValid()) tied.insert(keyframe.parent);
  for (const KeyFrameId other : tied) AddEdge(other, keyframe.id);
}

// As the poses are now.
void EssentialGraph::AddEdge(KeyFrameId from, KeyFrameId to) {
  const Sim3 from_from_to = MapFromKeyFrame(from).Inverse() * MapFromKeyFrame(to);
  graph_.edges.push_back({index_.at(from), index_.at(to), from_from_to});
}

double EssentialGraph::TypicalDistance() const {
  std::vector<double> distances;
  for (const PoseGraphEdge& edge : graph_.edges)
    distances.push_back(edge.from_from_to.rigid.translation().norm());
  if (distances.empty()) return 1;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return std::max(*middle, 1e-9);
}

void EssentialGraph::Weigh(double precision, PoseGraphEdge* edge) const {
  const double distance = std::max(edge->from_from_to.rigid.translation().norm(), typical_distance_);
  edge->translation_sigma = precision * kDriveTranslation * distance;
  edge->rotation_sigma = precision * kDriveRotation;
  edge->scale_sigma = precision * kDriveScale;
}

void EssentialGraph::MovePoints(Map* map) const {
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> moved;
  for (const auto& [id, point] : map->points()) {
    const KeyFrame& reference = *map->FindKeyFrame(point.reference_keyframe);
    const Eigen::Vector3d in_reference = reference.camera_from_map * point.position_in_map;
    moved.emplace_back(id, MapFromKeyFrame(reference.id) * in_reference);
  }
  for (const auto& [id, position] : moved) map->SetPosition(id, position);
}

void EssentialGraph::MoveKeyFrames(Map* map) const {
  for (const KeyFrameId id : ids_) {
    const Sim3& map_from_keyframe = MapFromKeyFrame(id);
    map->SetPose(id, map_from_keyframe.rigid.Inverse());
    if (map_from_keyframe.scale != 1) map->NoteRescaled(id, map_from_keyframe.scale);
  }
}

void EssentialGraph::WriteBack(Map* map) const {
  MovePoints(map);
  MoveKeyFrames(map);
}

}  // namespace semmap
